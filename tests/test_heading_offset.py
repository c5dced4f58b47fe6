# SPDX-License-Identifier: MIT
"""A heading that is off by a constant is told, by how much and what to write; a right one is not."""

import msgspec
import numpy as np
import pytest
from conftest import at_length, on_request
from recording_tools import in_vehicle_terms
from survey_boat import LAG
from survey_boat import TRUTH as TWIN
from survey_boat import boat as twin

from seatrial.boat.findings import Finding, FindingKind, finding_text
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.diagnostics.heading_offset import (
    psi_offset,
    without_error,
)
from seatrial.identification.estimator import output_error
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import DisturbanceForce
from tests.boats.hulls import MIDDLE, SMALL, driven
from tests.boats.motions import recorded

PUSH = DisturbanceForce(0.04, 2.0)
CHAIN = {"latency": 0.1, "lag": 0.1}


def less_by(recording, by):
    """The recording with headings less by so much [rad]."""
    return without_error(recording, lambda psi: np.full_like(psi, by))


def offsets(recordings, vehicle) -> tuple[Finding, ...]:
    kinds = FindingKind.HEADING_OFFSET, FindingKind.COMPASS_DEVIATION
    return output_error(recordings, vehicle).findings_of(*kinds)


@pytest.mark.parametrize(("degrees", "force"), [(4.0, None), at_length(4.0, PUSH), (-15.0, PUSH)])
def test_a_heading_that_is_off_is_told_with_the_line_to_write(degrees, force):
    vehicle, drives = driven(MIDDLE, CHAIN, seed=3, white=2e-3, seconds=120, drives=2, push=force)
    askew = [less_by(drive, -np.radians(degrees)) for drive in drives]
    (finding,) = offsets(askew, vehicle)
    assert finding.kind is FindingKind.HEADING_OFFSET
    assert np.degrees(finding.number("size")) == pytest.approx(abs(degrees), abs=0.6)
    assert np.degrees(finding.number("psi_offset")) == pytest.approx(degrees, abs=0.6)
    assert f"offset: {finding.number('psi_offset'):.4g} at pose: psi" in finding_text(finding)


@pytest.mark.parametrize(
    ("turns", "number", "seconds"), [("once", 1, 80), at_length("twice", 2, 120)]
)
def test_a_compass_near_iron_is_told_with_its_deviation(turns, number, seconds):
    vehicle, drives = driven(
        MIDDLE, CHAIN, seed=3, white=2e-3, seconds=seconds, drives=2, push=PUSH
    )
    error = np.radians(5.0)
    near = [without_error(one, lambda psi: -error * np.sin(number * psi + 0.7)) for one in drives]
    (finding,) = offsets(near, vehicle)
    assert finding.kind is FindingKind.COMPASS_DEVIATION
    assert finding.values["turns"] == turns
    assert np.degrees(finding.number("size")) == pytest.approx(5.0, abs=1.0)


@pytest.mark.system
def test_an_error_of_the_heading_that_lasts_may_take_the_offset_up():
    """Where nothing pushes the boat: coefficients are right then, and nothing needs to be said."""
    vehicle, drives = driven(MIDDLE, CHAIN, seed=3, white=2e-3, seconds=120, drives=2)
    model = output_error([less_by(drive, np.radians(15.0)) for drive in drives], vehicle)
    for name, right in MIDDLE.coefficients.items():
        assert model.values[name] == pytest.approx(right, abs=4.0 * model.standard_errors[name])


@pytest.mark.parametrize("force", [None, at_length(PUSH)])
@pytest.mark.parametrize("hull", [MIDDLE, SMALL])
@pytest.mark.parametrize("seed", [5, on_request(6)])
def test_a_right_heading_is_not_doubted(hull, seed, force):
    vehicle, drives = driven(hull, CHAIN, seed=seed, white=2e-3, seconds=120, drives=2, push=force)
    assert offsets(drives, vehicle) == ()


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("unit", "per"), [(None, 1.0), ("deg", 180.0 / np.pi)])
def test_the_offset_that_is_named_takes_the_error_off(axes, sign, unit, per):
    file = MIDDLE.vehicle([]).file
    column = msgspec.structs.replace(file.pose.psi, unit=unit, sign=sign, scale=2.0, offset=0.3)

    def reads(column) -> Vehicle:
        pose = msgspec.structs.replace(file.pose, psi=column)
        return Vehicle(msgspec.structs.replace(file, pose=pose, axes=axes))

    raw = np.column_stack([np.zeros((20, 2)), per * np.linspace(-2.0, 2.0, 20)])
    before = in_vehicle_terms(raw, reads(column))[:, 2]
    offset = psi_offset(reads(column), 0.1)
    after = in_vehicle_terms(raw, reads(msgspec.structs.replace(column, offset=offset)))[:, 2]
    np.testing.assert_allclose(before - after, 0.1, atol=1e-12)


def along_a_line(seed: int, ahead: float) -> tuple[Vehicle, Recording]:
    """Two thrusters astern drive to and fro and keep the heading by small corrections; markers ahead of the origin."""
    rng, vehicle = np.random.default_rng(seed), twin()
    p, tick, state, force = TWIN, 0.02, np.zeros(6), np.zeros(2)
    commands, poses, surge, until = [], [], 0.0, 5.0
    for k in range(round(150.0 / tick)):
        if k * tick >= until:
            surge, until = (
                rng.uniform(0.2, 1.0) * -np.sign(state[0] + 1e-9),
                until + rng.uniform(0.5, 3.0),
            )
        _, _, psi, u, v, r = state
        turn = np.clip(-0.5 * psi - 0.4 * r, -0.2, 0.2) if surge else 0.0
        commands.append((surge - turn, surge + turn))
        force += tick / LAG * (np.array([surge, turn]) - force)
        c, s = np.cos(psi), np.sin(psi)
        poses.append(state[:3] + np.array([ahead * c, ahead * s, 0.0]))
        push = rng.normal(size=3) * [0.1, 0.1, 0.15]
        rates = [
            c * u - s * v, s * u + c * v, r,
            p["X_vr"] * v * r + p["X_u"] * u + p["X_uu"] * abs(u) * u + p["X_F"] * force[0] + push[0],
            p["Y_ur"] * u * r + p["Y_v"] * v + p["Y_vv"] * abs(v) * v + push[1],
            p["N_r"] * r + p["N_rr"] * abs(r) * r + p["N_F"] * force[1] + push[2],
        ]  # fmt: skip
        state = state + tick * np.array(rates)
    t = tick * np.arange(len(poses))
    seen = np.array(poses)[::2] + 3e-3 * rng.normal(size=(len(poses[::2]), 3))
    return vehicle, recorded("line", vehicle, (t[::2], seen), (t, np.array(commands)))


@pytest.mark.parametrize("seed", [at_length(1), 2])
def test_headings_of_one_line_do_not_show_a_compass_near_iron(seed):
    """Its deviation would be as good as an offset; it was told where the markers are a quarter of a metre ahead."""
    vehicle, line = along_a_line(seed, 0.25)
    assert np.ptp(line.eta[:, 2]) < 2.0
    model = output_error([line], vehicle)
    assert model.findings_of(FindingKind.COMPASS_DEVIATION) == ()
