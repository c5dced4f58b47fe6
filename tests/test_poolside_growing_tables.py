# SPDX-License-Identifier: MIT
"""Tables that are followed while they are written."""

import time

import numpy as np
import pytest
from poolside_sources import VEHICLE, gathered, no_silence, poses_of, table, vehicle  # noqa: F401  a fixture
from waiting import until

from seatrial.poolside.sources import open_source
from seatrial.util.errors import FileError, RecordingError

pytestmark = pytest.mark.usefixtures("no_silence")


def test_a_table_that_grows_gives_what_it_reads_in_the_end(tmp_path):
    lines = table(tmp_path / "whole.csv")
    boat, path = vehicle(), tmp_path / "run.csv"
    source = open_source(f"follow:{path}", boat)
    with gathered(source) as events:
        until(lambda: source.problems)
        assert source.problems[0].startswith("waiting:")
        with path.open("w") as file:
            for text in ("t,x,y,psi,F_u", ",F_v,F_r\n", lines[0][:7]):
                file.write(text)
                file.flush()
                time.sleep(0.1)
            file.write(lines[0][7:] + "\n")
            for k in range(1, 200, 20):
                text = "\n".join(lines[k : k + 20]) + "\n"
                file.write(text[:33])
                file.flush()
                time.sleep(0.06)
                file.write(text[33:])
                file.flush()
        until(lambda: len(events) >= 400)
    recorded = list(open_source(str(tmp_path / "whole.csv"), boat, 0.0))
    assert [(e.kind, e.stamp) for e in poses_of(events)] == [
        (e.kind, e.stamp) for e in poses_of(recorded)
    ]
    for kind in ("pose", "command"):
        np.testing.assert_array_equal(
            *[[e.values for e in several if e.kind == kind] for several in (events, recorded)]
        )
    assert source.problems == ()


def test_a_large_table_that_was_begun_just_before_the_end_is_used_to_its_last_row(tmp_path):
    """A busy machine looks late: what was written before it is closed is used, of more blocks than one."""
    source = open_source(f"follow:{tmp_path / 'run.csv'}", vehicle())
    lines = table(tmp_path / "run.csv", 20_000)
    assert (tmp_path / "run.csv").stat().st_size > 1 << 20
    source.close()
    poses = poses_of(source)
    assert len(poses) == len(lines)
    assert source.problems == ()


def test_a_bad_row_of_a_growing_table_is_counted(tmp_path):
    lines = table(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open("a") as file:
        file.write("11,1,2\nx,y,z,1,2,3,4\n,,,,,,\n" + "a" * 100 + "\n" + lines[-1] + "\n")
    source = open_source(f"follow:{tmp_path / 'run.csv'}", vehicle())
    with gathered(source) as found:
        until(lambda: len(found) >= 402)
    assert len(found) == 402
    (text,) = source.problems
    assert "run.csv" in text
    assert "could not be used" in text
    assert "/tmp" not in text


def test_a_folder_that_grows(tmp_path):
    boat = vehicle(
        pose={**VEHICLE["pose"], "file": "poses.csv"},
        commands={**VEHICLE["commands"], "file": "commands.csv"},
    )
    with gathered(open_source(f"follow:{tmp_path}", boat)) as events:
        for name in ("poses.csv", "commands.csv"):
            time.sleep(0.1)
            table(tmp_path / name, 100)
        until(lambda: len(events) >= 200)
        assert len(poses_of(events)) == 100


def test_a_growing_table_without_a_column_or_that_shrinks_ends_with_an_error(tmp_path):
    path = tmp_path / "run.csv"
    table(path, 20)
    path.write_text(path.read_text().replace("psi", "phi"))
    with pytest.raises(RecordingError, match="no column 'psi'"):
        list(open_source(f"follow:{path}", vehicle()))
    table(path, 20)
    events = iter(open_source(f"follow:{path}", vehicle()))
    for _ in range(40):
        next(events)
    table(path, 5)
    with pytest.raises(FileError, match="became shorter"):
        next(events)
