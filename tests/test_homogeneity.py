# SPDX-License-Identifier: MIT
"""Recordings of a boat that changed between them are told, and by what; those of one boat are not."""

from dataclasses import replace

import pytest
from conftest import at_length, on_request

from seatrial.boat.findings import Finding, FindingKind, finding_text
from seatrial.identification.diagnostics.boat_changes import DISAGREEMENTS
from seatrial.identification.estimator import output_error
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import DisturbanceForce, PlanFile
from tests.boats.hulls import MIDDLE, SMALL, driven
from tests.boats.plans import driven_by, planned

PUSH = DisturbanceForce(0.04, 2.0)
THRUST = ("X_F", "Y_F", "N_F", "N_ud", "N_uu")


def plan_of(preset: str, seed: int, force: DisturbanceForce | None = None) -> PlanFile:
    return planned(preset, seed=seed, plant={"unmodelled": force})


def recordings(plan, vehicle, names):
    return driven_by(planned(plan, *names, seconds=100.0), vehicle)


def findings_after(plan, vehicle, what: str, factor: float) -> tuple[Finding, ...]:
    """Disagreements of S1 to S3 together with S4 to S6 of a boat that has changed by a factor."""
    changed = {
        name: value * factor if ("thrust" if name in THRUST else "drag") in what else value
        for name, value in plan.plant.coefficients.items()
    }
    other = planned(plan, coefficients=changed)
    before = recordings(plan, vehicle, ("S1", "S2", "S3"))
    after = recordings(other, vehicle, ("S4", "S5", "S6"))
    found = output_error([*before, *after], vehicle)
    return found.findings_of(*DISAGREEMENTS)


@pytest.mark.system
@pytest.mark.parametrize(
    ("what", "factor"),
    [("thrust", 0.9), at_length("thrust and drag", 0.85), at_length("drag", 0.8)],
)
def test_a_boat_that_changed_between_recordings_is_told_with_what_changed(mp, what, factor):
    found = findings_after(plan_of("hard", 500), mp, what, factor)
    assert [finding.kind for finding in found] == [FindingKind.HOMOGENEITY] * 3
    assert [finding.part("axis") for finding in found] == ["surge", "sway", "yaw"]
    assert {finding.values["quantity"] for finding in found} == {what}
    for finding in found:
        assert finding.number("change") == pytest.approx(1.0 - factor, abs=0.06)
        assert finding.part("lower") in ("S4-MP", "S5-MP", "S6-MP")
        assert finding.part("higher") in ("S1-MP", "S2-MP", "S3-MP")


@pytest.mark.system
def test_a_push_does_not_hide_it(mp):
    first, *others = findings_after(plan_of("hard", 501, PUSH), mp, "thrust", 0.85)
    assert first.part("axis") == "surge"
    assert {finding.values["quantity"] for finding in (first, *others)} == {"thrust"}


@pytest.mark.parametrize(
    ("preset", "force", "seed"),
    [
        ("paper-like", None, 510),
        on_request("hard", None, 510),
        on_request("paper-like", PUSH, 511),
        at_length("hard", PUSH, 510),
        *(on_request("hard", force, 511) for force in (None, PUSH)),
        on_request("paper-like", PUSH, 510),
    ],
)
def test_recordings_of_one_boat_agree(mp, preset, force, seed):
    assert findings_after(plan_of(preset, seed, force), mp, "thrust", 1.0) == ()


def test_a_payload_that_weighs_on_all_axes_alike_is_told_with_its_share_in_each():
    """Coriolis terms stay as they were; counted as drag, they had hidden sway and halved surge."""
    heavy = replace(MIDDLE, mass=tuple(1.3 * m for m in MIDDLE.mass))
    chain = {"latency": 0.1, "lag": 0.1}
    vehicle, (light,) = driven(MIDDLE, chain, seed=11, white=2e-3, seconds=150, drives=1)
    _, (loaded,) = driven(heavy, chain, seed=12, white=2e-3, seconds=150, drives=1)
    found = output_error([light, replace(loaded, name="loaded")], vehicle)
    told = found.findings_of(*DISAGREEMENTS)
    shares = {finding.part("axis"): finding.number("change") for finding in told}
    expected = pytest.approx(1.0 - 1.0 / 1.3, abs=0.04)
    assert shares == dict.fromkeys(("surge", "sway", "yaw"), expected)
    for finding in told:
        assert finding.values["quantity"] == "thrust and drag"
        assert finding.subject[1:] == ("loaded", light.name)
        assert "Possible cause: payload" in finding_text(finding)


@pytest.mark.system
@pytest.mark.parametrize(
    ("hull", "late"), [(MIDDLE, 0.05), at_length(MIDDLE, -0.3), at_length(SMALL, 0.1)]
)
def test_a_clock_that_was_set_anew_is_told_with_how_much_and_is_no_payload(hull, late):
    """All but one recording agree; stamps of its commands are late, so that these act early."""
    vehicle, (one, odd, other) = driven(
        hull, {"latency": 0.1, "lag": 0.1}, seed=3, white=2e-3, seconds=120, drives=3
    )
    told = odd.commands
    commands = Signal(told.names, told.stamps + round(late * 1e9), told.values)
    found = output_error([one, replace(odd, commands=commands), other], vehicle)
    (finding,) = found.findings_of(*DISAGREEMENTS)
    assert finding.kind is FindingKind.CLOCK_HOMOGENEITY
    assert finding.number("delay") == pytest.approx(abs(late), abs=0.02)
    assert finding.part("earlier" if late > 0.0 else "later") == odd.name
