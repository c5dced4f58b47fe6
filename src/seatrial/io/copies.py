# SPDX-License-Identifier: MIT
"""Rows that a log has twice: a block that is sent or written again after a reconnect, repeated messages."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.io.signals import Request, Rows
from seatrial.recording.faults.pose_faults import in_order
from seatrial.util.frames import Mask


def without_copies(
    read: Sequence[Rows], requests: Sequence[Request]
) -> tuple[list[Rows], tuple[str, ...]]:
    """The rows without exact copies of others, stamp and values alike, and how many each place has."""
    found, texts = [], []
    for rows, request in zip(read, requests, strict=True):
        copies = copies_in(rows)
        if copies.any():
            texts.append(
                f"{request.place}: {copies.sum()} of {len(copies)} rows are copies of others, stamp and values "
                "alike (a part of the log is sent or written twice): each row counts once, nothing is lost"
            )
        found.append(_kept(rows, ~copies) if copies.any() else rows)
    return found, tuple(dict.fromkeys(texts))


def copies_in(rows: Rows) -> Mask:
    """Rows (n,) outside the longest rising sequence of stamps that equal one in it."""
    if np.all(np.diff(rows.stamps) > 0):
        return np.zeros(len(rows.stamps), dtype=bool)
    first = in_order(rows.stamps)
    own = np.flatnonzero(first)
    if len(own) < 2:  # one row again and again is no recording
        return np.zeros(len(rows.stamps), dtype=bool)
    same = np.clip(np.searchsorted(rows.stamps[own], rows.stamps), 0, len(own) - 1)
    twin = own[same]
    alike = (rows.stamps == rows.stamps[twin]) & np.all(
        (rows.values == rows.values[twin]) | (np.isnan(rows.values) & np.isnan(rows.values[twin])),
        axis=1,
    )
    if rows.marked_valid is not None:
        alike &= rows.marked_valid == rows.marked_valid[twin]
    return np.asarray(alike & ~first)


def _kept(rows: Rows, kept: Mask) -> Rows:
    """Some of the rows, with the order of their stamps in what is known of the stream."""
    stamps = rows.stamps[kept]
    steps = np.diff(stamps)
    stream = replace(
        rows.stream,
        count=len(stamps),
        duplicated=int((steps == 0).sum()),
        backward=int((steps < 0).sum()),
    )
    marked, values = rows.marked_valid, rows.values[kept]
    marked = None if marked is None else marked[kept]
    return replace(rows, stamps=stamps, values=values, stream=stream, marked_valid=marked)
