# SPDX-License-Identifier: MIT
"""Workers of Dask: a cluster of this computer's processes, or one that a scheduler has."""

import logging
import pickle
import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import lru_cache, partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from seatrial.util.errors import FleetError
from seatrial.util.files import read_json
from seatrial.util.parallel import Farm, cores, on_one_core

if TYPE_CHECKING:
    from distributed import Client

C = TypeVar("C")
T = TypeVar("T")
R = TypeVar("R")

INSTALL = "pip install 'seatrial[fleet]'"
LOCAL = "local"
MOST_LOCAL_WORKERS = 1000
# [s] until the scheduler answers, until it has a worker
CONNECT_WITHIN, WORKERS_WITHIN = 10.0, 30.0
LOST = (
    "the scheduler has ended, or is not reached any more: look at its log, start it again, and repeat the "
    "command; a fleet goes on where it was"
)
SCHEMES = ("tcp://", "tls://", "ucx://", "ws://", "wss://")


class DaskFarm(Farm):
    """The workers of one scheduler. A worker that dies loses nothing: others do its items again."""

    def __init__(self, client: "Client") -> None:
        self._client = client

    def outcomes(
        self, work: Callable[[C, T], R], common: C, items: Sequence[T]
    ) -> Iterator[tuple[int, R | Exception]]:
        """As they end.

        `common` is a task of its own: scattered data would end with the worker that holds it. It travels as bytes:
        what a worker computes from it and keeps in it may not be able to travel on.
        """
        from distributed import as_completed

        one = partial(_worked, version("seatrial"), work)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph")  # recordings, once
            shared = self._client.submit(bytes, pickle.dumps(common), pure=False)
            futures = self._client.map(one, [shared] * len(items), items, pure=False)
        places = {future.key: place for place, future in enumerate(futures)}
        ended = as_completed(futures)
        del futures  # the cluster keeps a result as long as it has a future
        for future in ended:
            if future.cancelled():
                raise FleetError(LOST)
            error = future.exception()
            yield places[future.key], future.result() if error is None else _in_words(error)


@lru_cache(maxsize=1)
def _opened(common: bytes) -> Any:  # noqa: ANN401, as it was packed
    """What all items have in common, once for each worker."""
    return pickle.loads(common)


def _worked(expected: str, work: Callable[[C, T], R], common: bytes, item: T) -> R:
    """One item, on one core of a worker."""
    if (own := version("seatrial")) != expected:  # a worker that came later
        raise FleetError(
            f"a worker has seatrial {own}, here it is {expected}: install the same version on all computers"
        )
    with on_one_core():
        return work(_opened(common), item)


def _in_words(error: BaseException) -> Exception:
    """Errors of Dask itself as one line."""
    from distributed import KilledWorker

    if isinstance(error, KilledWorker):
        return FleetError(
            "several workers died while they worked on it: is the memory of a worker too small for it?"
        )
    return error if isinstance(error, Exception) else FleetError(str(error))


@contextmanager
def cluster(scheduler: str = LOCAL, workers: int | None = None) -> Iterator[DaskFarm]:
    """The workers of a scheduler: `local`, its address, or its file.

    `workers`: processes of `local`, default: all cores. Raises FleetError where no scheduler is there, or
    Dask is not installed.
    """
    with ExitStack() as stack:
        yield DaskFarm(_connected(stack, scheduler, workers))


def _connected(stack: ExitStack, scheduler: str, workers: int | None) -> "Client":
    try:
        from distributed import Client
    except ImportError:
        raise FleetError(f"workers of Dask need the package distributed: {INSTALL}") from None
    # what ended is no news, or an error of its own
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    if scheduler == LOCAL:
        return stack.enter_context(Client(_local(stack, workers)))
    if workers is not None:
        raise FleetError(f"--workers {workers}: the scheduler {scheduler} has its own workers")
    address = scheduler if scheduler.startswith(SCHEMES) else _address_in(Path(scheduler))
    try:
        client = stack.enter_context(Client(address, timeout=CONNECT_WITHIN))
        client.wait_for_workers(1, timeout=WORKERS_WITHIN)
    except (OSError, ValueError) as error:  # TimeoutError is one of the first
        raise FleetError(
            f"--scheduler {scheduler}: no scheduler with a worker answers ({type(error).__name__}); "
            "start them with 'dask scheduler' and 'dask worker', or leave the option out"
        ) from None
    _check_versions(client)
    return client


def _check_versions(client: "Client") -> None:
    """The same seatrial on all computers: the scheduler opens the work, too. Raises FleetError."""
    found = client.run(version, "seatrial", on_error="return")
    try:
        found["the scheduler"] = client.run_on_scheduler(version, "seatrial")
    except PackageNotFoundError as error:
        found["the scheduler"] = error
    for place, there in found.items():
        if there != version("seatrial"):
            other = "no seatrial" if isinstance(there, Exception) else f"seatrial {there}"
            raise FleetError(
                f"{place} has {other}, here it is {version('seatrial')}: install the same version on all computers"
            )


def _address_in(path: Path) -> str:
    """Of the scheduler that wrote a file."""
    if not path.is_file():
        raise FleetError(
            f"--scheduler {path}: expected {LOCAL}, an address such as tcp://10.0.0.5:8786, or the file of a "
            "scheduler; there is no such file"
        )
    address = read_json(path).get("address")
    if not isinstance(address, str) or not address.startswith(SCHEMES):
        raise FleetError(f"--scheduler {path}: no address of a scheduler in this file")
    return address


def _local(stack: ExitStack, workers: int | None) -> Any:  # noqa: ANN401, a class of Dask
    """Processes of this computer, reached by its loopback alone, without a dashboard."""
    from distributed import LocalCluster

    count = cores() if workers is None else workers
    if not 1 <= count <= MOST_LOCAL_WORKERS:
        raise FleetError(f"--workers {count}: expected 1 to {MOST_LOCAL_WORKERS}")
    scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="seatrial-"))
    return stack.enter_context(
        LocalCluster(
            n_workers=count, threads_per_worker=1, processes=True, host="127.0.0.1",
            dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL, local_directory=scratch,
        )
    )  # fmt: skip
