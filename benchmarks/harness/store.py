# SPDX-License-Identifier: MIT
"""Results in a file of JSON lines, one a scene and seed; what is there is not done again."""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from os import cpu_count, nice
from pathlib import Path

import seatrial
from benchmarks.recovery.scenes import scenes
from benchmarks.recovery.work import Record, work

SOURCES = ("src/seatrial", "core/include/seatrial", "benchmarks/recovery")
UNCONCERNED = {  # changes of these do not make results stale
    "io", "report", "init", "inspect", "cli.py", "demo.py", "validate.py", "bootstrap.py",
    "causal.py", "statistics.py", "tables.py", "figure.py", "store.py", "__main__.py", "reachable.py",
}  # fmt: skip
ROOT = Path(seatrial.__file__).resolve().parents[2]
POLITE = 10  # niceness of the workers


def code() -> str:
    """A digest of the code that the results depend on."""
    digest = hashlib.sha256()
    for folder in SOURCES:
        for path in sorted((ROOT / folder).rglob("*")):
            parts = set(path.relative_to(ROOT / folder).parts)
            if path.suffix in {".py", ".hpp", ".yaml"} and not parts & UNCONCERNED:
                digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def read(path: Path) -> list[Record]:
    """All results; a last line that was cut off is left out."""
    if not path.exists():
        return []
    lines = path.read_text().splitlines(keepends=True)
    return [json.loads(line) for line in lines if line.endswith("\n")]


def chosen(records: Iterable[Record], *, any_code: bool) -> list[Record]:
    """Those of the present code."""
    present = code()
    return [r for r in records if any_code or r["code"] == present]


def run(
    path: Path, names: Iterable[str], seeds: Iterable[int], said: Callable[[str], None]
) -> None:
    """Add what is missing; a seed's scenes together, so that a run that ends early is even."""
    present = code()
    done = {(r["scene"], r["seed"]) for r in read(path) if r["code"] == present}
    missing = [(n, s) for s in seeds for n in names if (n, s) not in done]
    said(f"{len(missing)} to do, {len(done)} done with this code ({present})")
    path.parent.mkdir(parents=True, exist_ok=True)
    _end_line(path)
    with path.open("a") as out:
        for i, record in enumerate(_worked(missing), start=1):
            out.write(json.dumps(record | {"code": present}) + "\n")
            out.flush()
            outcome = record.get("failed", f"{record.get('seconds', 0.0):.1f} s")
            said(f"{i}/{len(missing)} {record['scene']} {record['seed']}: {outcome}")


def _end_line(path: Path) -> None:
    """A line that was cut off must not swallow the next."""
    if path.exists() and not path.read_text().endswith("\n"):
        kept = [json.dumps(r) + "\n" for r in read(path)]
        path.write_text("".join(kept))


def _worked(items: list[tuple[str, int]]) -> Iterator[Record]:
    pool = ProcessPoolExecutor(
        cpu_count() or 1, mp_context=get_context("spawn"), initializer=nice, initargs=(POLITE,)
    )
    with pool:
        for future in as_completed([pool.submit(_one, name, seed) for name, seed in items]):
            yield future.result()


def _one(name: str, seed: int) -> Record:
    return work(scenes()[name], seed)
