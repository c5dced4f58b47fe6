# SPDX-License-Identifier: MIT
"""Commands that are forces, no thrusters in the vehicle file: a usual layout whose dead zone explains the drive."""

import dataclasses

import msgspec
import pytest
from boats.hulls import CROSS, FREE, MIDDLE, TUG, driven
from conftest import at_length

import seatrial
from seatrial.boat.findings import FindingKind, of_kinds
from seatrial.boat.schema import AllocationEntry
from seatrial.identification.estimator import fit
from seatrial.identification.first_search import first_maximum
from seatrial.identification.likelihood.whiteness import without_process_noise
from seatrial.identification.selection.thruster_layout import (
    LAYOUTS,
    contradicted_layout,
    forces_alone,
    select_layout,
    with_layout,
)
from seatrial.simulation.plan import DisturbanceForce

EDGES = {"forward": 0.1, "reverse": 0.12}
PUSH = DisturbanceForce(0.03, 2.0, earth_fixed=True)
TOED_IN = [(-0.35, 0.2, 20.0), (-0.35, -0.2, -20.0), (0.4, 0.05, 80.0)]  # no usual layout


def without_thrusters(vehicle):
    file = msgspec.structs.replace(
        vehicle.file, thrusters={}, allocation=AllocationEntry(limit=1.0), chain=[], structure=FREE
    )
    return dataclasses.replace(vehicle, file=file)


def chosen(hull, dead_zone):
    chain = {"latency": 0.05, "lag": 0.1, **({"dead_zone": dead_zone} if dead_zone else {})}
    vehicle, recordings = driven(hull, chain, seed=3, white=1e-3, seconds=60.0)
    plain = without_thrusters(vehicle)
    return select_layout(first_maximum(recordings, plain), plain), hull.coefficients


@pytest.mark.parametrize(
    ("hull", "layout"),
    [
        (MIDDLE, "four in an X, all ahead"),
        (dataclasses.replace(MIDDLE, places=CROSS), "two ahead and two across"),
    ],
)
def test_the_layout_is_found_and_forces_are_those_beyond_the_dead_zone(hull, layout):
    found, truth = chosen(hull, EDGES)
    assert found.layout == layout
    values = dict(zip(found.at.runs.problem.names, found.at.theta.tolist(), strict=True))
    assert values["X_F"] == pytest.approx(truth["X_F"], rel=0.03)
    assert values["N_F"] == pytest.approx(truth["N_F"], rel=0.03)
    assert values["edge_forward"] == pytest.approx(EDGES["forward"], abs=0.015)
    assert values["edge_reverse"] == pytest.approx(EDGES["reverse"], abs=0.015)


def test_without_a_dead_zone_and_within_the_limits_none_is_chosen(monkeypatch):
    from boats import hulls

    gentle = hulls.sticks
    monkeypatch.setattr(hulls, "sticks", lambda *given: 0.4 * gentle(*given))
    found, _ = chosen(MIDDLE, None)
    assert found is None


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_vehicle_with_a_layout_reads_like_one_of_the_user(layout, mp):
    plain = without_thrusters(mp)
    assert forces_alone(plain)
    given = with_layout(plain, layout)
    assert not forces_alone(given)
    assert given.inputs == plain.inputs
    assert given.chain is not None  # the allocation has an inverse


def stated_wrong(vehicle, wrong):
    """The vehicle file with a mistake in its thrusters."""
    thrusters = dict(vehicle.file.thrusters)
    if wrong == "one is missing":
        thrusters.pop("t4")
    if wrong == "one points aside":
        thrusters["t2"] = msgspec.structs.replace(thrusters["t2"], angle_deg=135.0)
    return dataclasses.replace(
        vehicle, file=msgspec.structs.replace(vehicle.file, thrusters=thrusters)
    )


@pytest.mark.parametrize(
    ("wrong", "rate"),
    [
        ("one is missing", 12.0),
        at_length("one is missing", 30.0),
        at_length("one points aside", 12.0),
    ],
)
def test_thrusters_that_the_recordings_contradict_are_told(wrong, rate):
    chain = {"lag": 0.1, "dead_zone": EDGES}
    vehicle, recordings = driven(MIDDLE, chain, seed=3, white=1e-3, rate=rate, seconds=40.0)
    solution = fit(recordings, stated_wrong(vehicle, wrong))
    (found,) = contradicted_layout(solution)
    assert found.values["layout"] == "four in an X, all ahead"
    assert found.number("gain") > 1000.0


@pytest.mark.parametrize(
    "places", [MIDDLE.places, *(at_length(places) for places in (CROSS, TUG, TOED_IN))]
)
def test_right_thrusters_are_not_contradicted_where_something_pushes(places):
    hull = dataclasses.replace(MIDDLE, places=places)
    chain = {"lag": 0.1, "dead_zone": EDGES}
    vehicle, recordings = driven(hull, chain, seed=4, push=PUSH, white=1e-3, seconds=60.0)
    solution = fit(recordings, vehicle)
    assert not without_process_noise(solution.point)
    assert contradicted_layout(solution) == []


@pytest.mark.system
def test_a_method_names_the_layout_that_it_takes():
    chain = {"lag": 0.1, "dead_zone": EDGES}
    vehicle, recordings = driven(MIDDLE, chain, seed=3, white=1e-3, seconds=200.0)
    plain = without_thrusters(vehicle).with_automatic_structure()
    model = seatrial.identify(recordings, plain, method="weak-form")
    (found,) = of_kinds(model.estimator.findings, FindingKind.THRUSTER_LAYOUT_SELECTED)
    assert found.values["layout"] == "four in an X, all ahead"
    assert len(model.vehicle.file.thrusters) == 4


def test_a_prior_has_the_layout_already():
    """Else its dead zone would be one of whole axes."""
    chain = {"lag": 0.1, "dead_zone": EDGES}
    vehicle, recordings = driven(MIDDLE, chain, seed=3, white=1e-3, seconds=60.0)
    plain = without_thrusters(vehicle).with_automatic_structure()
    old = seatrial.identify(recordings, plain)
    assert old.vehicle.file.thrusters
    new = seatrial.identify(recordings[:1], plain, prior=old)
    assert new.vehicle.file.thrusters == old.vehicle.file.thrusters
    assert new.vehicle.file.allocation == old.vehicle.file.allocation
    assert new.values["X_F"] == pytest.approx(MIDDLE.coefficients["X_F"], rel=0.03)


def test_a_boat_without_sway_thrust_has_none_of_them(mp):
    plain = without_thrusters(mp)
    inputs = {name: column for name, column in plain.file.commands.inputs.items() if name != "F_v"}
    commands = msgspec.structs.replace(plain.file.commands, inputs=inputs)
    narrow = dataclasses.replace(
        plain, file=msgspec.structs.replace(plain.file, commands=commands, structure="auto")
    )
    assert narrow.inputs == ("F_u", "F_r")
    assert not forces_alone(narrow)
