# SPDX-License-Identifier: MIT
"""More than 10 000 damaged bags, tables and vehicle files: one line each, in time, in memory."""

import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

FUZZ = Path(__file__).with_name("fuzz.py")
CASES = {"bag": 2500, "mcap": 2500, "db3": 1500, "csv": 2000, "yaml": 1500, "inspect": 400}
WORKERS = 2
BATCH = 1250  # cases of a worker
TIMEOUT = 600.0  # [s] of a worker: a hang that no timer ends


def work(kind: str, first: int, count: int) -> tuple[list[dict], dict]:
    """Findings, and what came of all; a worker that died is a finding."""
    command = [sys.executable, "-W", "error", str(FUZZ), kind, str(first), str(count)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=TIMEOUT, env=environment
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    findings = [line for line in lines if "error" in line]
    if not lines or "outcomes" not in lines[-1] or done.returncode not in (0, 1):
        last = f"ended with {done.returncode} after {len(lines)} lines: {done.stderr[-2000:]}"
        return [*findings, {"kind": kind, "case": f"{first} to {first + count}", "error": last}], {}
    return findings, lines[-1]


@pytest.fixture(scope="module")
def results():
    batches = [
        (kind, first, min(BATCH, count - first))
        for kind, count in CASES.items() for first in range(0, count, BATCH)
    ]  # fmt: skip
    with ThreadPoolExecutor(WORKERS) as pool:
        return list(pool.map(lambda batch: (batch[0], *work(*batch)), batches))


def test_there_are_more_than_ten_thousand():
    assert sum(CASES.values()) >= 10_000


@pytest.mark.parametrize("kind", CASES)
def test_damage_ends_in_a_recording_or_in_one_line(results, kind):
    findings = [f for k, found, _ in results if k == kind for f in found]
    shown = "\n".join(
        f"python -W error tests/fuzz.py {f['kind']} {f['case']} 1\n{f['error'][-700:]}"
        for f in findings[:5]
    )
    assert not findings, f"{len(findings)} findings, the first of them:\n{shown}"
    said = [summary for k, _, summary in results if k == kind]
    assert sum(s["count"] for s in said) == CASES[kind]
    assert max(s["peak [MB]"] for s in said) < 600
    assert max(s["slowest"][0] for s in said) < 10.0


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_the_damage_is_real_and_salvage_helps(results, kind):
    """A good part is refused, a good part read; with salvage more is read than without."""
    outcomes: dict[str, int] = {}
    for k, _, summary in results:
        for word, count in summary["outcomes"].items() if k == kind else ():
            outcomes[word] = outcomes.get(word, 0) + count
    plain = outcomes["read"] / (outcomes["read"] + outcomes["refused"])
    salvaged = outcomes["salvaged"] / (outcomes["salvaged"] + outcomes["salvage refused"])
    assert 0.02 < plain < 0.5
    assert salvaged > 1.5 * plain


def test_a_case_can_be_had_again():
    """The same number is the same case, in another process."""
    shown = [
        subprocess.run(
            [sys.executable, str(FUZZ), "bag", "7", "1", "--digest"],
            capture_output=True, text=True, check=True,
        ).stdout
        for _ in range(2)
    ]  # fmt: skip
    assert shown[0] == shown[1]
    assert re.search(r'"digest": "[0-9a-f]{64}"', shown[0])
