# SPDX-License-Identifier: MIT
"""Bags that a recorder splits, followed from one to the next."""

from pathlib import Path

import pytest
from bag_tools import joy_sent, poses_sent, ros1
from bag_tools import vehicle as bag_boat
from mcap_writer import mcap
from poolside_sources import gathered, no_silence  # noqa: F401  a fixture
from waiting import until

from seatrial.io.bags.growing.ros1 import GrowingRos1
from seatrial.poolside.sources import open_source

pytestmark = pytest.mark.usefixtures("no_silence")


def test_a_folder_of_ros1_bags_is_followed_from_one_to_the_next(tmp_path):
    sent = sorted(poses_sent(6.0) + joy_sent(6.0), key=lambda s: s.time)
    folder = tmp_path / "run"
    folder.mkdir()
    first = ros1(folder / "run_0.bag", sent[:300]).rename(folder / "run_0.bag.active")
    source = open_source(f"follow:{folder}", bag_boat())
    with gathered(source) as found:
        until(lambda: found)
        first.rename(folder / "run_0.bag")
        ros1(tmp_path / "run_1.bag", sent[300:]).rename(folder / "run_1.bag.active")
    assert source.problems == ()
    assert len(sent) - 5 < len(found) <= len(sent)


def test_a_file_of_a_split_recording_without_a_message_is_passed(tmp_path):
    """As rosbag writes it where it is split before the first message: the header of a bag and nothing else."""
    folder, sent = tmp_path / "run", poses_sent(2.0)
    folder.mkdir()
    header = ros1(tmp_path / "whole.bag", sent).read_bytes()[:4117]
    (folder / "run_0.bag").write_bytes(header)
    bag = GrowingRos1(folder)
    assert bag.grow() == bag.grow() == set()
    ros1(folder / "run_1.bag", sent)
    (folder / "run_2.bag").write_bytes(header)
    ros1(folder / "run_3.bag", sent)
    for _ in range(12):
        bag.grow()
    (topic,) = bag.topics.values()
    assert topic.messages == 2 * len(sent)


@pytest.mark.parametrize("step", ["glob", "exists", "open"])
def test_no_message_is_lost_when_a_bag_gets_its_last_name(tmp_path, monkeypatch, step):
    """The recorder renames at any moment: here before each step of the search in turn."""
    folder = tmp_path / "run"
    folder.mkdir()
    active = ros1(tmp_path / "run_0.bag", poses_sent(1.0)).rename(folder / "run_0.bag.active")
    plain, calls = getattr(Path, step), []

    def renamed_before(self, *arguments, **named):
        if tmp_path in self.parents:
            calls.append(self)
            if len(calls) == nth:
                monkeypatch.setattr(Path, step, plain)
                active.rename(folder / "run_0.bag")
        found = plain(self, *arguments, **named)
        return iter(list(found)) if step == "glob" else found

    bag, nth = GrowingRos1(folder), 2 if step == "glob" else 1
    monkeypatch.setattr(Path, step, renamed_before)
    bag.grow()
    (topic,) = bag.topics.values()
    assert topic.messages == len(poses_sent(1.0))
    assert (folder / "run_0.bag").exists()


def test_a_folder_of_mcap_files_is_followed_from_one_to_the_next(tmp_path):
    sent = sorted(poses_sent(6.0) + joy_sent(6.0), key=lambda s: s.time)
    folder = tmp_path / "run"
    folder.mkdir()
    mcap(folder / "run_0.mcap", sent[:300])
    with gathered(open_source(f"follow:{folder}", bag_boat())) as found:
        until(lambda: len(found) > 200)
        mcap(folder / "run_1.mcap", sent[300:])
        until(lambda: len(found) > len(sent) - 5)
    assert len(sent) - 5 < len(found) <= len(sent)
    assert [e.kind for e in found].count("pose") == len(poses_sent(6.0))


def test_bags_that_were_written_before_the_end_are_all_used(tmp_path):
    """Of a folder: the first was being read when the others were written, and the source closed."""
    sent = sorted(poses_sent(6.0) + joy_sent(6.0), key=lambda s: s.time)
    mcap(tmp_path / "run_0.mcap", sent[:300])
    with open_source(f"follow:{tmp_path}", bag_boat()) as source:
        events = iter(source)
        found = [next(events)]
        mcap(tmp_path / "run_1.mcap", sent[300:400])
        mcap(tmp_path / "run_2.mcap", sent[400:])
        source.close()
        found += events
    assert len(sent) - 5 < len(found) <= len(sent)
