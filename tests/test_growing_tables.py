# SPDX-License-Identifier: MIT
"""What can't be used of a table or bag that grows: found at little cost, named, and nothing else is lost."""

import pytest
from bag_tools import by_time, joy_sent, poses_sent
from bag_tools import vehicle as bag_boat
from mcap_writer import mcap
from poolside_sources import poses_of, table, vehicle

from seatrial.poolside.sources import open_source
from seatrial.poolside.sources.follow import BLOCK, GrowingTable
from seatrial.util.errors import RecordingError

BAD = "x,y,z,1,2,3,4"


def followed(path):
    """The events of all that was written, and what is said of it."""
    source = open_source(f"follow:{path}", vehicle())
    source.close()
    return list(source), source.problems


def test_one_bad_row_of_many_costs_few_tables_and_is_named_by_its_line(tmp_path, monkeypatch):
    path, made = tmp_path / "run.csv", []
    lines = table(path, 8000)
    path.write_text(path.read_text().replace(lines[4000], BAD))
    plain = GrowingTable.table
    monkeypatch.setattr(GrowingTable, "table", lambda *given: made.append(1) or plain(*given))
    events, (said,) = followed(path)
    assert len(poses_of(events)) == 7999
    assert "run.csv line 4002: column 'x' has 'y'" in said  # the header is line 1
    assert len(made) < 40  # by halves: 2 log2(8000)


def test_lines_without_a_row_count_as_lines_and_are_no_mistakes(tmp_path):
    path = tmp_path / "run.csv"
    lines = table(path, 50)
    text = path.read_text()
    head = text.partition("\n")[0]
    path.write_text(text.replace(f"{lines[20]}\n", f"\n# again\n{head}\n{lines[20]}\n"))
    events, said = followed(path)
    assert len(poses_of(events)) == 50 and said == ()
    path.write_text(path.read_text().replace(lines[30], "30,1"))
    events, (said,) = followed(path)
    assert len(poses_of(events)) == 49
    assert "1 of " in said and "run.csv line 35: 2 cells, expected 7" in said


def test_a_block_of_rows_that_can_not_be_used_hides_none_after_it(tmp_path):
    path = tmp_path / "run.csv"
    lines = table(path, 50)
    many = f"{lines[10]}\n" + "# a comment, of a block alone\n" * (BLOCK // 10)
    path.write_text(path.read_text().replace(f"{lines[10]}\n", many))
    assert path.stat().st_size > 2 * BLOCK
    events, said = followed(path)
    assert len(poses_of(events)) == 50 and said == ()


def test_a_growing_table_without_a_column_is_named_and_not_its_copy(tmp_path):
    path = tmp_path / "run.csv"
    table(path, 20)
    path.write_text(path.read_text().replace("psi", "phi"))
    with pytest.raises(RecordingError, match=r"^run\.csv: no column 'psi'"):
        followed(path)


def test_poses_of_a_bag_that_can_not_be_used_take_no_commands_with_them(tmp_path):
    """The tracker begins anew in another frame: of those messages no pose is the vehicle's."""
    other = [sent for sent in poses_sent(4.0, frame="odom") if sent.time > poses_sent(2.0)[-1].time]
    sent = by_time(poses_sent(2.0) + other + joy_sent(4.0))
    mcap(tmp_path / "run_0.mcap", sent[: len(sent) // 2])
    mcap(tmp_path / "run_1.mcap", sent[len(sent) // 2 + 4 :])
    source = open_source(f"follow:{tmp_path}", bag_boat(pose={"parent": "map"}))
    source.close()
    events = list(source)
    commands = [s for s in sent[: len(sent) // 2] + sent[len(sent) // 2 + 4 :] if s.topic == "/joy"]
    assert [e.kind for e in events].count("command") == len(commands)
    assert 0 < len(poses_of(events)) <= len(poses_sent(2.0))
    (said,) = source.problems
    assert "no pose on /slam/pose has header.frame_id 'map'" in said
