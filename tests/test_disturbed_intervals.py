# SPDX-License-Identifier: MIT
"""Stretches in which a hand moved the boat: found, named, left out; and none where there are none."""

import re
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from cli_tools import done, refused
from conftest import TABLE_II, make_model
from method_trials import pulses_of

import seatrial
from seatrial.boat.findings import FindingKind, finding_text, of_kinds
from seatrial.commands.cli import main
from seatrial.evaluation.disturbed_intervals import (
    MOST_INTERVALS,
    disturbed_intervals,
    interval_findings,
)
from seatrial.evaluation.prediction import predict
from seatrial.identification.console import summary
from seatrial.identification.selection.terms.select_terms import of_files
from seatrial.io.trial_files import write_trial
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.from_poses import make_recording
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.errors import IdentificationError, RecordingError

HELD = 12.0  # [s] at the end of a recording
FRUITFUL = 0.2  # of the standard errors with a stretch, those without it


def made(seconds=200.0, rate=8.0, name="S1", uneven=0.0, seed=0):
    """What is needed of a recording, and squared errors of a right model."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / rate)
    t[1:] += uneven / rate * rng.uniform(-0.5, 0.5, len(t) - 1)
    here = SimpleNamespace(name=name, t=t, period=1.0 / rate, duration=float(t[-1]), offset=0.0)
    return here, rng.chisquare(3, len(t))


@pytest.mark.parametrize("rate", [1.0, 4.0, 8.0, 30.0])
def test_right_models_have_none(rate):
    for seed in range(10):
        cases = [
            made(seconds, rate, seed=seed + 100 * i) for i, seconds in enumerate((60, 200, 900))
        ]
        assert disturbed_intervals(*zip(*cases, strict=True)) == []


def test_heavy_tails_all_over_are_none():
    here, squares = made()
    rng = np.random.default_rng(1)
    squares = squares * np.where(rng.random(len(squares)) < 0.05, 8.0, 1.0)
    assert disturbed_intervals([here], [squares]) == []


@pytest.mark.parametrize(
    ("begin", "end"), [(0.0, 6.0), (60.0, 62.0), (100.0, 140.0), (186.0, 200.0)]
)
def test_a_stretch_is_found_where_it_is(begin, end):
    other, quiet = made(name="S2", seed=1)
    here, squares = made()
    squares[(here.t >= begin) & (here.t < end)] *= 5.0
    (found,) = disturbed_intervals([other, here], [quiet, squares])
    assert found.recording == 1
    assert found.start == pytest.approx(begin, abs=2.0)
    assert found.end == pytest.approx(end, abs=2.0)
    assert found.times == pytest.approx(np.sqrt(5.0), rel=0.2)


def test_several_are_found_and_those_side_by_side_are_one():
    here, squares = made()
    for begin, end in ((20.0, 22.0), (80.0, 84.0), (87.0, 91.0), (150.0, 152.0)):
        squares[(here.t >= begin) & (here.t < end)] *= 6.0
    found = disturbed_intervals([here], [squares])
    assert [(round(s.start), round(s.end)) for s in found] == [(20, 22), (80, 92), (150, 152)]
    listed = interval_findings([here], found)
    assert [(f.number("start"), f.number("end")) for f in listed] == [
        (20, 22),
        (80, 92),
        (150, 152),
    ]
    said = [finding_text(finding) for finding in listed]
    assert "S1 from 80 s to 92 s" in said[1]
    assert said[1].endswith("--without S1=80-92")


def test_what_happens_all_the_time_is_no_exception():
    here, squares = made(800.0)
    for begin in np.arange(20.0, 790.0, 30.0):
        squares[(here.t >= begin) & (here.t < begin + 4.0)] *= 6.0
    assert MOST_INTERVALS < 790 / 30
    assert disturbed_intervals([here], [squares]) == []
    squares = made(800.0)[1]
    squares[here.t < 420.0] *= 3.0  # half of it
    assert disturbed_intervals([here], [squares]) == []


def test_poses_that_are_not_used_do_not_count():
    here, squares = made(uneven=0.8)
    squares[(here.t >= 40.0) & (here.t < 50.0)] = np.nan
    assert disturbed_intervals([here], [squares]) == []
    squares[(here.t >= 50.0) & (here.t < 54.0)] *= 6.0
    (found,) = disturbed_intervals([here], [squares])
    assert found.end == 54.0


def test_names_for_a_shell_and_ends_of_a_part():
    here, squares = made(name="S1 morning")
    squares[here.t < 3.0] *= 8.0
    squares[here.t > 193.0] *= 8.0
    here.offset = 0.0
    assert options(here, squares) == [
        "--without 'S1 morning'=0-4",
        "--without 'S1 morning'=192-199.9",
    ]
    here.offset = 12.5  # what --start left of it
    assert options(here, squares) == [
        "--without 'S1 morning'=12.5-16.5",
        "--without 'S1 morning'=204.5-212.4",
    ]


def options(here, squares):
    """What leaves out the intervals that are found in one recording."""
    found = interval_findings([here], disturbed_intervals([here], [squares]))
    return [finding_text(of_files(f)).partition("exclude it with ")[2] for f in found]


def carried(recording, *, begin=0.0, end=HELD, size=0.5):
    """The recording, its boat carried about by hand at the beginning and at the end [s]."""
    eta, t = recording.raw.copy(), recording.t
    for here, ago in ((t < begin, begin - t), (t > t[-1] - end, t - t[-1] + end)):
        s = ago[here]
        eta[here] += size * np.column_stack(
            [1.0 - np.cos(0.5 * s), 0.6 * np.sin(0.7 * s), 1.2 * np.sin(0.4 * s)]
        )
    return make_recording(
        recording.name, recording.stamps, eta, recording.commands, sources=recording.sources
    )


@pytest.fixture(scope="module")
def handled(paper_mp):
    """S1 to S3, the second with a hand at its end."""
    own = [paper_mp[name].recording for name in ("S1", "S2", "S3")]
    return [own[0], carried(own[1]), own[2]]


@pytest.fixture(scope="module")
def with_hand(handled, mp):
    return seatrial.identify(handled, mp)


def disturbed(model):
    return model.findings_of(FindingKind.DISTURBED_INTERVAL)


@pytest.mark.system
def test_a_boat_that_is_carried_is_named_with_what_leaves_it_out(handled, with_hand):
    (finding,) = disturbed(with_hand)
    said, name = finding_text(finding), handled[1].name
    assert said in summary(with_hand)
    assert finding.part("recording") == name
    begin, end = finding.number("start"), finding.number("end")
    assert begin == pytest.approx(handled[1].duration - HELD, abs=2.5)
    assert end == pytest.approx(handled[1].duration, abs=0.1)
    assert said.endswith(f"--without {name}={begin:g}-{end:g}")
    (influence,) = with_hand.findings_of(FindingKind.DISTURBANCE_INFLUENCE)
    assert influence.number("ratio") < FRUITFUL
    assert influence.part("parameter") in with_hand.parameters


@pytest.mark.system
def test_without_it_the_model_is_as_good_as_ever(handled, with_hand, paper_mp_model, mp):
    left = [handled[0], handled[1].without(handled[1].duration - HELD - 1.0, 1e9), handled[2]]
    model = seatrial.identify(left, mp)
    assert disturbed(model) == ()
    assert not any("left out" in w for w in model.warnings)  # it was asked for
    was, now, never = (np.sqrt(np.diag(m.covariance)) for m in (with_hand, model, paper_mp_model))
    assert np.all(now[:9] < FRUITFUL * was[:9])
    assert now == pytest.approx(never, rel=0.3)
    plant = plant_model(load_plan("paper-like"), mp)
    off = np.array([model.values[n] - plant.values[n] for n in model.values])
    assert np.abs(off / now[: len(off)]).max() < 3.5
    ((begin, end),) = model.recordings[1].without
    assert begin == pytest.approx(handled[1].duration - HELD - 1.0, abs=1e-3)
    assert end == pytest.approx(handled[1].duration, abs=1e-3)


@pytest.mark.system
@pytest.mark.parametrize("size", [0.2, 1.0])
def test_boats_that_are_put_in_and_taken_out_are_named_be_there_a_solution_or_not(mp, size):
    own = [r.cut(0.0, 120.0) for r in pulses_of(load_plan("paper-like"), mp)]
    recordings = [carried(r, begin=10.0, end=15.0, size=size) for r in own]
    try:
        said = " ".join(map(finding_text, seatrial.identify(recordings, mp).estimator.findings))
    except IdentificationError as error:
        said = str(error)
        assert "There is a solution without some of it" in said
    found = re.findall(r"--without (S\d-MP)=([\d.]+)-(\d+)", said)
    assert [name for name, *_ in found] == [name for r in own for name in [r.name] * 2]
    for _, begin, end in found[::2]:
        assert begin == "0"
        assert 10.0 <= float(end) <= 20.0
    for _, begin, end in found[1::2]:
        assert 100.0 <= float(begin) <= 106.0
        assert float(end) >= 119.0


def test_recordings_without_a_hand_have_no_such_note(paper_mp_model):
    assert disturbed(paper_mp_model) == ()


@pytest.mark.system
def test_what_a_poor_structure_does_not_explain_is_no_hand(cse1, cse1_vehicle):
    model = seatrial.identify([cse1["random_run3"]], cse1_vehicle)
    assert model.findings_of(FindingKind.MODEL_MISMATCH)
    assert disturbed(model) == ()


def test_validation_names_it_too(handled, paper_mp, paper_mp_model):
    found = seatrial.validate(paper_mp_model, [handled[1], paper_mp["S7"].recording])
    first, second = (of_kinds(r.findings, FindingKind.DISTURBED_INTERVAL) for r in found.recordings)
    assert {finding.part("recording") for finding in first} == {handled[1].name}
    assert second == ()


def test_options_for_parts_of_recordings_are_those_of_the_recordings():
    """`select` cuts in parts what was driven once."""
    here, squares = made(name="S1 morning part 2 of 2")
    squares[(here.t >= 60.0) & (here.t < 62.0)] *= 8.0
    here.offset = 100.0
    assert options(here, squares) == ["--without 'S1 morning'=160-162"]
    here.name = "S2 part 13 of 16"
    assert options(here, squares) == ["--without S2=160-162"]


def test_nothing_is_predicted_through_what_is_left_out(paper_mp, mp):
    recording = paper_mp["S1"].recording
    model = make_model(mp, TABLE_II["MP"])
    whole, part = (predict(model, r, 1.0) for r in (recording, recording.without(50.0, 60.0)))
    inside = (whole.t > 50.0 - 1.5) & (whole.t < 60.0 + 1.5)
    assert len(part.t) < len(whole.t) - 0.7 * inside.sum()
    assert not np.any((part.t > 50.1) & (part.t < 60.0))


def test_a_recording_without_a_stretch(paper_mp):
    recording = paper_mp["S1"].recording
    left = recording.without(50.0, 60.0).without(100.0, 1e9)
    assert not left.valid[(left.t >= 50.0) & (left.t <= 60.0)].any()
    assert not left.valid[left.t >= 100.0].any()
    kept = (left.t < 50.0) | ((left.t > 60.0) & (left.t < 100.0))
    np.testing.assert_array_equal(left.valid[kept], recording.valid[kept])
    spans = [(f.start, f.end) for f in left.faults if f.kind is FaultKind.EXCLUDED]
    assert spans == [(50.0, 60.0), (100.0, pytest.approx(recording.duration))]
    assert left.usable == pytest.approx(recording.usable, abs=0.01)
    np.testing.assert_array_equal(left.commands.values, recording.commands.values)
    later = left.cut(40.0, 90.0)
    assert [round(f.start) for f in later.faults if f.kind is FaultKind.EXCLUDED] == [10]
    for start, end, words in (
        (60.0, 50.0, "from 60 s to 50 s: the end is not after the start"),
        (500.0, 600.0, "can't exclude from 500 s to 600 s: it lasts"),
        (-1.0, np.inf, "no poses remain without the time from -1 s to its end"),
        (float("nan"), 5.0, "the end is not after the start"),
    ):
        with pytest.raises(RecordingError, match=words):
            recording.without(start, end)


@pytest.fixture(scope="module")
def on_disk(paper_mp, tmp_path_factory):
    return write_trial(paper_mp["S1"], tmp_path_factory.mktemp("disturbed_intervals"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("S1-MP", "expected NAME=FROM-TO, a recording and seconds from its start, such as S2=83-97"),
        ("S1-MP=a-b", "expected NAME=FROM-TO"),
        ("S1-MP=1.2.3-5", "expected NAME=FROM-TO"),
        ("S1-MP=9-5", "from 9 s to 5 s: the end is not after the start"),
        ("S1-MP=-", "no poses remain without the time from 0 s to its end"),
        ("S2-MP=5-9", "--without S2-MP: there is no such recording; S1-MP"),
    ],
)  # fmt: skip
def test_a_stretch_that_can_not_be_left_out_is_one_line(on_disk, capsys, text, words):
    assert words in refused(
        capsys, "inspect", on_disk, "--vehicle", "mallard-mp", "--without", text
    )


def test_commands_leave_out_what_they_are_told(on_disk, capsys):
    told = ["--without", "S1-MP=-5", "--without", "S1-MP=80.5-90", "--without", "S1-MP=110-"]
    shown = done(capsys, "inspect", on_disk, "--vehicle", "mallard-mp", *told, "--start", "60")
    assert "excluded (--without)" in shown


def test_a_recording_is_told_by_its_path_where_another_has_its_name(on_disk, tmp_path, capsys):
    copy = shutil.copytree(on_disk, tmp_path / on_disk.name)
    both = ["inspect", str(on_disk), str(copy), "--vehicle", "mallard-mp", "--without"]
    assert "2 recordings are called so; give its path" in refused(capsys, *both, "S1-MP=80-90")
    assert main([*both, f"{copy}/=80-90"]) == 0
    first, second = capsys.readouterr().out.split("S1-MP")[1:3]
    assert "excluded (--without)" not in first
    assert "excluded (--without)" in second
