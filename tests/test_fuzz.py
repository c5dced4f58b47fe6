# SPDX-License-Identifier: MIT
"""Damaged bags, logs of autopilots, tables and vehicle files, 600 or more than 10 000: one line each, in time, in memory."""

import json
import os
import re
import sys
from pathlib import Path

import pytest
from programs import piped, printed

FUZZ = Path(__file__).with_name("fuzz.py")
FEW = {
    "bag": 90, "mcap": 90, "db3": 60, "log": 100, "csv": 80, "capture": 40, "parquet": 60, "mat": 60,
    "hdf": 60, "yaml": 60, "inspect": 20,
}  # fmt: skip
ALL = {  # with the few, which come first; those of the first batch after them run in CI, the others on request
    "bag": 1800,
    "mcap": 1800,
    "db3": 1200,
    "log": 10_000,
    "csv": 1500,
    "capture": 1000,
    "parquet": 1000,
    "mat": 1000,
    "hdf": 1000,
    "yaml": 1000,
    "inspect": 400,
}
MEMORY = Path("/dev/shm")  # a folder without a disk
BATCH = 600  # cases of one program at most
TIMEOUT = 600.0  # [s] of a program: a hang that no timer ends


def work(kind: str, first: int, count: int) -> tuple[list[dict], dict]:
    """Findings, and what came of all; a program that died is a finding."""
    command = [sys.executable, "-W", "error", str(FUZZ), kind, str(first), str(count)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    if MEMORY.is_dir():  # thousands of small files
        environment["TMPDIR"] = str(MEMORY)
    done = piped(command, timeout=TIMEOUT, env=environment)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    findings = [line for line in lines if "error" in line]
    if not lines or "outcomes" not in lines[-1] or done.returncode not in (0, 1):
        last = f"ended with {done.returncode} after {len(lines)} lines: {done.stderr[-2000:]}"
        return [*findings, {"kind": kind, "case": f"{first} to {first + count}", "error": last}], {}
    return findings, lines[-1]


def batch(kind: str, first: int, count: int, **more) -> object:
    return pytest.param(kind, first, count, id=f"{kind}-{first}-{first + count}", **more)


BATCHES = [
    *(batch(kind, 0, count) for kind, count in FEW.items()),
    *(
        batch(kind, first, min(BATCH, count - first),
              marks=pytest.mark.system if first == FEW[kind] else pytest.mark.study)
        for kind, count in ALL.items() for first in range(FEW[kind], count, BATCH)
    ),
]  # fmt: skip


def test_there_are_more_than_ten_thousand():
    assert sum(FEW.values()) - FEW["log"] >= 600
    assert sum(ALL.values()) - ALL["log"] >= 10_000
    assert FEW["log"] >= 100
    assert ALL["log"] >= 10_000


@pytest.mark.parametrize(("kind", "first", "count"), BATCHES)
def test_damage_ends_in_a_recording_or_in_one_line(kind, first, count):
    """Of bags a good part is refused, a good part read; with salvage more is read than without."""
    findings, summary = work(kind, first, count)
    shown = "\n".join(
        f"python -W error tests/fuzz.py {f['kind']} {f['case']} 1\n{f['error'][-700:]}"
        for f in findings[:5]
    )
    assert not findings, f"{len(findings)} findings, the first of them:\n{shown}"
    assert summary["count"] == count
    assert summary["peak [MB]"] < 600
    assert summary["slowest"][0] < 10.0
    if kind in ("bag", "mcap", "db3"):
        outcomes = summary["outcomes"]
        plain = outcomes["read"] / (outcomes["read"] + outcomes["refused"])
        salvaged = outcomes["salvaged"] / (outcomes["salvaged"] + outcomes["salvage refused"])
        assert 0.02 < plain < 0.5
        # a .db3 is also read without its metadata, where they are damaged
        assert salvaged > (1.0 if kind == "db3" else 1.5) * plain
    if kind == "log":  # most damage costs a few messages, which are counted
        assert summary["outcomes"]["read"] > 0.3 * count
        assert summary["outcomes"]["refused"] > 0.02 * count
        assert summary["outcomes"]["proposed"] > 0.01 * count


def test_a_case_can_be_had_again():
    """The same number is the same case, in another process."""
    shown = [
        printed(sys.executable, FUZZ, "bag", "7", "1", "--digest")
        for _ in range(2)
    ]  # fmt: skip
    assert shown[0] == shown[1]
    assert re.search(r'"digest": "[0-9a-f]{64}"', shown[0])
