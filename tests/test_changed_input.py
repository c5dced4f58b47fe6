# SPDX-License-Identifier: MIT
"""A thruster that stops or weakens within a recording is named, with when, and init is right all the same."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import CSE1, at_length
from init_tools import proposed
from sheets import sheet
from steered_boat import known
from survey_boat import as_stated, driven, even, past_idle

import seatrial
from seatrial.boat.findings import FindingKind
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.simulation.plan import DisturbanceForce
from seatrial.simulation.trials import simulate
from seatrial.workflow.next_step import after_inspect
from tests.boats.plans import planned
from tests.boats.vehicles import TWIN_TRUTH

NOISE = np.array([0.02, 0.02, 0.02])  # [m], [m], [rad]
LENGTH, CHANGE = 480.0, 300.0  # [s]
ALLOCATION = {"F_u": {"left": 0.5, "right": 0.5}, "F_r": {"left": -0.5, "right": 0.5}}


def weaker(factor, *, seed=1, after=CHANGE, until=LENGTH):
    """A drive whose right thruster has a part of its effect for a time; the log has what was commanded."""

    def effect(t):
        weak = (t >= after) & (t < until)
        return np.column_stack([np.ones(len(t)), np.where(weak, factor, 1.0)])

    return driven(
        {}, [past_idle] * 2, seconds=LENGTH, seed=seed, stamps=even(5.0), noise=NOISE, effect=effect
    )


def changes(recordings, vehicle):
    found = check_consistency(recordings, vehicle).findings
    return [one.text for one in found if one.kind is InconsistencyKind.CHANGED]


@pytest.mark.parametrize(
    ("factor", "seed"), [(0.0, 1), at_length(0.0, 2), (0.5, 3), at_length(0.5, 4)]
)
def test_a_thruster_that_weakens_is_named_with_when(factor, seed):
    vehicle, drive = weaker(factor, seed=seed)
    (text,) = changes([drive], vehicle)
    words = text.split()
    assert words[0] == "right"
    assert float(words[4]) == pytest.approx(factor, abs=0.1)
    assert float(words[9]) == pytest.approx(CHANGE - 4.0, abs=4.0)
    assert f"--without drive={words[9]}-" in text


def test_times_are_those_of_the_file_and_names_are_quoted():
    vehicle, drive = weaker(0.0)
    (text,) = changes([replace(drive.cut(60.0), name="my drive")], vehicle)
    assert float(text.partition("--without 'my drive=")[2].rstrip("-'")) == pytest.approx(
        CHANGE, abs=8.0
    )


def test_one_that_is_weak_at_first_is_named_with_until_when():
    vehicle, drive = weaker(0.3, after=0.0, until=150.0)
    (text,) = changes([drive], vehicle)
    assert text.startswith("right moves the boat 0.3")
    end = int(text.partition("--without drive=-")[2])
    assert end == pytest.approx(154, abs=4)


def written(drive, folder):
    """The drive as two tables."""
    folder.mkdir()
    sheet(folder / "poses.csv", "t,x,y,psi", drive.t, drive.eta)
    t = 1e-9 * (drive.commands.stamps - drive.origin)
    sheet(folder / "commands.csv", "t,left,right", t, drive.commands.values)
    return folder


def test_the_proposed_forces_are_those_of_the_rest_which_gives_the_model(tmp_path):
    """A mixture of both parts looked as if one thruster had no force, or a share of it."""
    folder = written(weaker(0.0)[1], tmp_path / "drive")
    found, vehicle = proposed(folder)
    assert {name: force.of for name, force in vehicle.file.forces.items()} == ALLOCATION
    assert "# check: right moves the boat" in found.text
    whole = seatrial.read(folder, vehicle)
    (finding,) = seatrial.identify([whole], vehicle).findings_of(FindingKind.CONTRADICTED)
    assert "--without drive=" in finding.values["text"]
    step = after_inspect(seatrial.inspect([whole], vehicle), [folder], "boat.yaml")
    assert step.do.startswith(f"seatrial identify {folder} --without drive=29")
    model = seatrial.identify([whole.without(CHANGE - 5.0, np.inf)], vehicle)
    assert not model.findings_of(FindingKind.CONTRADICTED)


@pytest.mark.system
@pytest.mark.parametrize("until", [None, 150.0])
def test_auto_leaves_the_part_out_and_says_so(until, tmp_path):
    part = {} if until is None else {"after": 0.0, "until": until}
    folder = written(weaker(0.4, **part)[1], tmp_path / "drive")
    found = seatrial.auto([folder], tmp_path / "out", say=lambda _: None)
    (line,) = [one for one in found.assumed if "is left out: right moves" in one]
    assert line.startswith("drive=-15" if until else "drive=29")
    assert not found.model.findings_of(FindingKind.CONTRADICTED)
    assert not as_stated(found.model, {n: v for n, v in TWIN_TRUTH.items() if n in ("X_u", "N_r")})


def test_a_channel_that_moves_nothing_has_no_effect_to_change():
    """Of the ship's seven channels two are no thrusters; a large step of one was taken for a change."""
    bags = [CSE1 / "mcap" / f"CSE1_data_random_run{k}.mcap" for k in (1, 3)]
    found = init(*bags, choices=Choices(name="cse1", axes="forward-right-down"))
    assert "as in the rest" not in found.text


@pytest.mark.parametrize("seed", [1, 2])
def test_neither_a_battery_nor_a_dead_zone_is_one(seed):
    fall = lambda t: np.column_stack([1.0 - 0.3 * t / LENGTH] * 2)  # noqa: E731
    for curve, effect in (({}, fall), ({"dead_zone": {"forward": 0.2, "reverse": 0.2}}, None)):
        vehicle, drive = driven(
            curve,
            [past_idle] * 2,
            seconds=LENGTH,
            seed=seed,
            stamps=even(5.0),
            noise=NOISE,
            effect=effect,
        )
        assert changes([drive], vehicle) == []


def test_an_angle_has_no_effect_of_its_own_to_change():
    """In gusts the helm seemed to turn the boat less while there was little thrust."""
    boat = known()
    gusts = {"unmodelled": DisturbanceForce(0.08, 3.0, earth_fixed=True)}
    trials = simulate(planned("lake", "L1", "L2", "L3", plant=gusts), boat.vehicle, boat)
    assert changes([trial.recording for trial in trials], boat.vehicle) == []
