# SPDX-License-Identifier: MIT
"""Workers of a command: its options, and the farm that they ask for."""

import argparse
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager

    from seatrial.util.parallel import Farm


def add_workers(command: argparse.ArgumentParser, default: str | None = None) -> None:
    """--scheduler and --workers."""
    command.add_argument(
        "--scheduler", default=default, metavar="WHERE",
        help="Dask workers that share the work: local, tcp://HOST:PORT, or a scheduler's file (default: "
        + (default or "this process") + ")",
    )  # fmt: skip
    command.add_argument(
        "--workers", type=int, metavar="N",
        help="processes of --scheduler local (default: all cores)"
        + ("; 0: this process, without Dask" if default else ""),
    )  # fmt: skip


def workers_of(args: argparse.Namespace) -> "AbstractContextManager[Farm] | None":
    """The workers that a command's options name; None: this process."""
    from seatrial.util.errors import FleetError

    if args.scheduler is None and args.workers is not None:
        raise FleetError(f"--workers {args.workers} belongs to --scheduler local")
    if args.scheduler is None or (args.scheduler == "local" and args.workers == 0):
        return None
    from seatrial.fleet.dask_cluster import cluster

    return cluster(args.scheduler, args.workers)


@contextmanager
def on_workers(args: argparse.Namespace) -> "Iterator[None]":
    """Long work inside is done by the workers that a command's options name."""
    from seatrial.util.parallel import working_on

    workers = workers_of(args)
    if workers is None:
        yield
        return
    with workers as farm, working_on(farm):
        yield
