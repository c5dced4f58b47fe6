# SPDX-License-Identifier: MIT
"""Digests of written files: a file that was edited since is not overwritten."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from seatrial.util.files import dump_json, sha256, write_text

DIGESTS = "written.json"


def edited(folder: Path, notes: Path) -> list[Path]:
    """Files below `folder` whose digest differs from the one in `notes`."""
    known = {folder / name: digest for name, digest in _known(notes).items()}
    return [p for p, digest in known.items() if p.is_file() and sha256(p) != digest]


@contextmanager
def noted(folder: Path, notes: Path, paths: Sequence[Path]) -> Iterator[None]:
    """Record the digests of `paths` below `folder` after the body; none if it fails."""
    names = {p.relative_to(folder).as_posix(): p for p in paths}
    rest = {name: digest for name, digest in _known(notes).items() if name not in names}
    write_text(notes, dump_json(rest))  # if the body fails, they do not count as edited
    yield
    write_text(notes, dump_json(rest | {name: sha256(p) for name, p in names.items()}))


def _known(notes: Path) -> dict[str, str]:
    try:
        content = json.loads(notes.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return {str(k): str(v) for k, v in content.items()} if isinstance(content, dict) else {}
