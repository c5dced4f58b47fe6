# SPDX-License-Identifier: MIT
"""Results in a file of JSON lines, one a job; what is there is not done again."""

import hashlib
import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.harness.workers import Job, Workers, spread

SOURCES = ("src/seatrial", "core/include/seatrial", "tests/boats")
UNCONCERNED = {  # changes of these do not make results stale
    "commands", "control", "export", "inspection", "io", "onboard", "report", "tables.py",
    "figure.py", "page.py", "__main__.py", "reachable.py",
}  # fmt: skip
ROOT = Path(__file__).resolve().parents[2]
Record = dict[str, Any]


def code(benchmark: str) -> str:
    """A digest of the code that results depend on; `benchmark` is its folder in benchmarks/."""
    digest = hashlib.sha256()
    for folder in (*SOURCES, f"benchmarks/{benchmark}"):
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


def chosen(records: Iterable[Record], present: str, *, any_code: bool = False) -> list[Record]:
    """Those of the present code."""
    return [r for r in records if any_code or r.get("code") == present]


def run(
    path: Path,
    jobs: Sequence[Job],
    work: Callable[..., Record],
    present: str,
    workers: Workers = None,
) -> None:
    """Add what is missing of the jobs, with the digest of the present code."""
    known = read(path)
    done = {tuple(r.get("job", ())) for r in chosen(known, present)}
    missing = [job for job in jobs if job not in done]
    print(f"{len(missing)} to do, {len(jobs) - len(missing)} done with this code ({present})")
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists() and not path.read_text().endswith("\n"):  # else it swallows the next line
        path.write_text("".join(json.dumps(r) + "\n" for r in known))
    with path.open("a") as out:
        for i, (job, record) in enumerate(spread(work, missing, workers), start=1):
            out.write(json.dumps(record | {"job": list(job), "code": present}) + "\n")
            out.flush()
            outcome = record.get("failed", "done")
            print(f"{i}/{len(missing)} {' '.join(map(str, job))}: {outcome}", flush=True)
