# SPDX-License-Identifier: MIT
"""Damaged bags, logs of autopilots, tables and vehicle files: mutations of good ones, the same for the same number.

    python -W error tests/fuzz.py bag 0 1000        # cases 0 to 999 of a kind
    python -W error tests/fuzz.py db3 417 1 --keep /tmp/case

Every case must end in a recording (or a vehicle), or in a SeatrialError of one line, in time and
within the memory that a worker has. Anything else is printed as a finding.
"""

import argparse
import contextlib
import hashlib
import io
import json
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import FrameType

from fuzz_seeds import PROPOSED, Data, boat, one_table, seeds, tables
from mutations import ODD_WORDS, ODD_YAML, bomb, damaged, edited, queried

import seatrial
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.io import formats
from seatrial.io.formats import open_log
from seatrial.io.log import Wanted
from seatrial.io.look import look
from seatrial.util.errors import SeatrialError

MEMORY = 3 << 29  # [bytes] 1.5 GB of addresses for a worker, libraries included
PATIENCE = 10.0  # [s] of the processor for one case, however busy the machine is
LONGEST = 3000  # [characters] of a line that somebody is to read
KINDS = ("bag", "mcap", "db3", "log", "csv", "capture", "parquet", "mat", "hdf", "yaml", "inspect")
LONG_LOG = 100_000  # [bytes]


class SlowError(Exception):
    """A case that takes too long."""


def made(kind: str, case: int, good: dict[str, list[Data]]) -> tuple[Data, bool]:
    """The damaged files of a case, and whether they are to be salvaged."""
    rng = random.Random(f"{kind} {case}")
    family = good["bag" if kind == "inspect" else kind]
    files = dict(rng.choice(family))
    target = rng.choice(sorted({*files} - {"commands.csv"} if kind == "capture" else files))
    content = files[target]
    others = [other for seed in family for other in seed.values()]
    if target == "metadata.yaml" and rng.random() < 0.7:
        files[target] = edited(rng, content, ODD_YAML, " :")
    elif kind == "db3" and target.endswith(".db3") and rng.random() < 0.4:
        files[target] = queried(rng, content)
    elif (kind in ("csv", "capture") or target == "run.log") and rng.random() < 0.7:
        files[target] = edited(rng, content, ODD_WORDS, ",")
    elif kind == "yaml" and rng.random() < 0.9:
        files[target] = (
            bomb(rng) if rng.random() < 0.02 else edited(rng, content, ODD_YAML, " ,:[]{}")
        )
    else:
        files[target] = damaged(rng, content, others)
    return files, rng.random() < 0.5


def attempt(kind: str, folder: Path, files: Data, *, salvage: bool) -> str:
    """What came of it, in a word. Raises what must not be raised."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    whole = len(files) > 1
    path = folder if whole else folder / next(iter(files))
    try:
        if kind == "yaml":
            vehicle = seatrial.load_vehicle(path)
            (folder / "tables").mkdir()
            for name, content in {**tables(), **one_table()}.items():
                (folder / "tables" / name).write_bytes(content)
            seatrial.read(folder / "tables", vehicle)
            return "read"
        if kind == "log":
            return _log(path)
        tree = any(b"TFMessage" in content for content in files.values())
        if kind == "inspect":
            return _inspected(path, tree=tree)
        if kind in ("csv", "capture", "parquet", "mat", "hdf"):
            look(path)
        if kind == "capture":
            init(path)
            return "read"
        seatrial.read(path, boat(tree=tree)[0], salvage=salvage)
    except SeatrialError as error:
        _one_line(str(error))
        return "salvage refused" if salvage else "refused"
    return "salvaged" if salvage else "read"


def _log(path: Path) -> str:
    """All fields of all topics; then the recording by the whole log's vehicle file, or a new proposal."""
    formats._opened.cache_clear()  # a case may have the size and, to the clock's tick, the time of the one before
    log = open_log(path)
    topics = [*log.topics.values()]
    read = log.read([Wanted(topic.name, topic.fields) for topic in topics])
    for topic, samples in zip(topics, read, strict=True):
        assert len(samples.stamps) + samples.dropped <= topic.messages
        assert samples.values.shape == (len(samples.stamps), len(topic.fields))
    size = path.stat().st_size
    if size % 7 == 0 or (size > LONG_LOG and size % 2 == 0):
        init(path, choices=Choices(axes="forward-right-down"))
        return "proposed"
    seatrial.read(path, PROPOSED[path.name])
    return "read"


def _inspected(path: Path, *, tree: bool) -> str:
    """Through the command line."""
    from seatrial.commands.cli import main as command_line

    vehicle = path.parent / "vehicle.yaml"
    vehicle.write_text(boat(tree=tree)[1])
    said, told = io.StringIO(), io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(told):
        code = command_line(["inspect", "-q", str(path), "--vehicle", str(vehicle)])
    if code == 0:
        return "inspected"
    assert code == 1, code
    _one_line(said.getvalue().rstrip("\n"))
    return "refused"


def _one_line(text: str) -> None:
    assert text.strip(), "an error without words"
    assert text.isprintable(), f"not one line of text: {text!r}"
    assert len(text) < LONGEST, f"{len(text)} characters: {text[:300]}"


def _late(_signal: int, _frame: FrameType | None) -> None:
    raise SlowError


def cases(
    kind: str, first: int, count: int, keep: Path | None = None
) -> Iterator[dict[str, object]]:
    """Run them; yields one finding each, and last what came of all."""
    good = seeds(kind)
    outcomes: Counter[str] = Counter()
    slowest, which = 0.0, 0
    signal.signal(signal.SIGPROF, _late)
    with tempfile.TemporaryDirectory() as name:
        for case in range(first, first + count):
            files, salvage = made(kind, case, good)
            folder = Path(name) / "case"
            folder.mkdir()
            begin = time.process_time()
            signal.setitimer(signal.ITIMER_PROF, PATIENCE)
            try:
                outcomes[attempt(kind, folder, files, salvage=salvage)] += 1
            except BaseException as error:
                if isinstance(error, KeyboardInterrupt):
                    raise
                signal.setitimer(signal.ITIMER_PROF, 0.0)
                where = traceback.format_exception(error)
                yield {
                    "kind": kind,
                    "case": case,
                    "salvage": salvage,
                    "error": "".join(where)[-3000:],
                }
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            took = time.process_time() - begin
            if took > slowest:
                slowest, which = took, case
            if keep is not None:
                shutil.copytree(folder, keep, dirs_exist_ok=True)
            shutil.rmtree(folder)
    yield {
        "kind": kind, "first": first, "count": count, "outcomes": dict(outcomes),
        "slowest": [slowest, which], "peak [MB]": peak(),
    }  # fmt: skip


def peak() -> int:
    """Largest memory of this program [MB]; `getrusage` has that of its parent before exec, too."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) >> 10


def main() -> int:
    """Run cases of one kind with bounded memory."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("first", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("--keep", type=Path, help="folder for the files of the last case")
    parser.add_argument("--digest", action="store_true", help="only say what the first case is")
    args = parser.parse_args()
    if args.digest:
        files, _ = made(args.kind, args.first, seeds(args.kind))
        digest = hashlib.sha256(b"".join(name.encode() + c for name, c in sorted(files.items())))
        sys.stdout.write(json.dumps({"case": args.first, "digest": digest.hexdigest()}) + "\n")
        return 0
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    found = 0
    for line in cases(args.kind, args.first, args.count, args.keep):
        found += "error" in line
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()
    return min(found, 1)


if __name__ == "__main__":
    sys.exit(main())
