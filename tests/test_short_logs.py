# SPDX-License-Identifier: MIT
"""Logs of autopilots and of MOOS in which hardly anything moves: the message has the numbers. As in public logs."""

import numpy as np
import pytest
from autopilot_logs import TWIN, trial
from init_tools import proposed
from moos_logs import moos

import seatrial
from seatrial.util.errors import RecordingError


def lines_of(path):
    """Banner and postings."""
    lines = path.read_text().splitlines()
    return [x for x in lines if x.startswith("%")], [x for x in lines if not x.startswith("%")]


def written(path, *parts):
    path.write_text("\n".join(line for part in parts for line in part) + "\n")
    return path


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return moos(tmp_path_factory.mktemp("moos") / "run.alog", trial(TWIN, 60.0, 0))


@pytest.mark.parametrize(("variable", "count"), [("NAV_X", 4), ("NAV_X", 1)])
def test_few_positions_are_counted(tmp_path, whole, variable, count):
    """Of a boat that had hardly left: they do change."""
    banner, body = lines_of(whole)
    seen = {"NAV_X": 0, "NAV_Y": 0}
    kept = []
    for line in body:
        name = line.split()[1]
        if name in seen:
            seen[name] += 1
            if seen[name] > count:
                continue
        kept.append(line)
    path = written(tmp_path / "short.alog", banner, kept)
    with pytest.raises(
        RecordingError, match=f"NAV_XY has {count} in {count} messages .no fix"
    ) as e:
        proposed(path)
    assert "fewer than 20 different positions" in str(e.value)


def test_few_headings_are_counted(tmp_path, whole):
    banner, body = lines_of(whole)
    kept = [
        f"{line[:63]}90.0" if " NAV_HEADING " in line and float(line.split()[0]) > 1 else line
        for line in body
    ]
    path = written(tmp_path / "short.alog", banner, kept)
    with pytest.raises(
        RecordingError, match=r"20 different values at least \(NAV_HEADING has 6 in 300"
    ):
        proposed(path)


def test_values_that_the_logger_writes_again_as_it_begins_count_once(tmp_path, whole):
    """pLogger registers for all variables a second time: it then gets the last posting of each again."""
    banner, body = lines_of(whole)
    last = {line.split()[1]: line for line in body[:60]}
    path = written(tmp_path / "twice.alog", banner, body[:60], sorted(last.values()), body[60:])
    _, vehicle = proposed(whole)
    one, two = (seatrial.read(p, vehicle) for p in (whole, path))
    np.testing.assert_array_equal(two.stamps, one.stamps)
    np.testing.assert_array_equal(two.eta, one.eta)
    np.testing.assert_array_equal(two.commands.values, one.commands.values)
