# SPDX-License-Identifier: MIT
"""Allocation, every scheme by the same contract; AF against the paper's Table I as printed."""

import numpy as np
import pytest
import survey_boat
import yaml
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import seatrial
from seatrial import _core
from seatrial.boat.allocation import Scheme, Thruster, inverse_for, thruster_matrix
from seatrial.boat.vehicle import vehicle_from
from seatrial.util.errors import VehicleError

S = np.array([[-1, -1, 1, 1], [1, -1, 1, -1], [1, -1, -1, 1]])  # Table I, rows F_u, F_v, F_r
MP, AF = seatrial.load_vehicle("mallard-mp"), seatrial.load_vehicle("mallard-af")
WRENCHES = arrays(float, (7, 3), elements=st.floats(-2, 2))


def table_one(F: np.ndarray, F_os: float) -> np.ndarray:
    """Table I and Eq. (11), line by line."""
    f = np.full(4, F_os)
    Fu, Fv, Fr = F
    if Fu > 0:
        f += [0, 0, abs(Fu), abs(Fu)]
    elif Fu < 0:
        f += [abs(Fu), abs(Fu), 0, 0]
    if Fv > 0:
        f += [abs(Fv), 0, abs(Fv), 0]
    elif Fv < 0:
        f += [0, abs(Fv), 0, abs(Fv)]
    if Fr > 0:
        f += [abs(Fr), 0, 0, abs(Fr)]
    elif Fr < 0:
        f += [0, abs(Fr), abs(Fr), 0]
    return f


def test_mallards_geometry_gives_half_the_sign_matrix():
    np.testing.assert_allclose(MP.mix, S / 2, atol=1e-15)


@pytest.mark.parametrize("vehicle", [MP, AF], ids=["MP", "AF"])
@given(wrench=WRENCHES)
def test_the_wrench_given_is_alpha_times_the_wrench_asked(vehicle, wrench):
    f, alpha = _core.allocate(vehicle.chain, wrench)
    np.testing.assert_allclose(f @ vehicle.mix.T, alpha[:, None] * wrench, atol=1e-12)
    assert np.all((alpha >= 0) & (alpha <= 1))


@pytest.mark.parametrize("vehicle", [MP, AF], ids=["MP", "AF"])
@given(wrench=WRENCHES)
def test_no_thruster_passes_its_limit_and_none_is_held_back_without_need(vehicle, wrench):
    f, alpha = _core.allocate(vehicle.chain, wrench)
    assert np.abs(f).max() <= 1.0 + 1e-12
    held = alpha < 1 - 1e-12
    np.testing.assert_allclose(np.abs(f[held]).max(axis=1, initial=0.0), 1.0, atol=1e-9)


@given(wrench=WRENCHES)
def test_always_forward_never_goes_under_its_offset(wrench):
    f, _ = _core.allocate(AF.chain, wrench)
    assert f.min() >= 0.12 - 1e-15


@given(wrench=arrays(float, (7, 3), elements=st.floats(-0.29, 0.29)))
def test_always_forward_is_table_one(wrench):
    f, alpha = _core.allocate(AF.chain, wrench)
    assert np.all(alpha == 1.0)
    np.testing.assert_allclose(f, [table_one(F, 0.12) for F in wrench], atol=1e-15)


@given(wrench=WRENCHES)
def test_moore_penrose_is_the_least_effort(wrench):
    f, alpha = _core.allocate(MP.chain, wrench)
    want = (np.linalg.pinv(S / 2) @ (alpha[:, None] * wrench).T).T
    np.testing.assert_allclose(f, want, atol=1e-12)


def test_always_forward_costs_half_the_authority():
    """The design's price of AF: with F_os = 0 a full F_u alone fills the thrusters; MP needs half."""
    f_af, _ = _core.allocate(AF.chain, np.array([[0.5, 0.0, 0.0]]))
    f_mp, _ = _core.allocate(MP.chain, np.array([[0.5, 0.0, 0.0]]))
    assert f_af.max() - 0.12 == pytest.approx(2 * f_mp.max())


def test_a_direct_vehicle_passes_its_commands_on(cse1_vehicle):
    commands = np.random.default_rng(0).uniform(-1, 1, (9, 5))
    f, alpha = _core.allocate(cse1_vehicle.chain, commands)
    assert np.array_equal(f, commands)
    assert np.all(alpha == 1)


def test_three_thrusters_in_a_row_can_not_turn_and_shift():
    row = [Thruster(f"t{i}", x, 0.0, 0.0) for i, x in enumerate((-0.2, 0.0, 0.2))]
    with pytest.raises(VehicleError, match="rank"):
        thruster_matrix(row)


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
def test_two_thrusters_astern_are_refused_with_the_forces_to_write(axes):
    """In the axes of the file; a thruster on the file's second side turns the boat against its yaw."""
    content = survey_boat.boat().to_mapping()
    forces = content.pop("forces")
    content["axes"] = axes
    side = 1.0 if axes == "forward-left-up" else -1.0
    places = {"left": 0.2 * side, "right": -0.2 * side}
    content["thrusters"] = {n: {"x": -0.3, "y": y, "angle_deg": 0} for n, y in places.items()}
    with pytest.raises(VehicleError, match=r"^two\.yaml: thrusters: these 2 can't") as caught:
        vehicle_from(content, "two.yaml").mix  # noqa: B018
    written = yaml.safe_load(str(caught.value).split("in place of thrusters: forces: ")[1])
    assert written["F_u"] == {"axis": "surge", "of": {"left": 1, "right": 1}}
    assert written["F_r"] == {"axis": "yaw", "of": {"left": -0.2 * side, "right": 0.2 * side}}
    assert set(written) == set(forces)
    content.pop("thrusters")
    assert vehicle_from(content | {"forces": written}, "two.yaml").mix.shape == (2, 2)


def test_always_forward_is_refused_where_the_idle_pushes_do_not_cancel():
    angles = np.deg2rad([0.0, 120.0, 240.0])
    three = [
        Thruster(f"t{i}", 0.2 * np.cos(a), 0.2 * np.sin(a), a + np.pi / 2)
        for i, a in enumerate(angles)
    ]
    T, scale = thruster_matrix(three)
    assert np.allclose(np.linalg.norm(T, axis=1), 1.0)
    assert scale[2] == pytest.approx(0.2 * np.sqrt(3))
    inverse_for(Scheme.MP, T)
    with pytest.raises(VehicleError, match="moore-penrose"):
        inverse_for(Scheme.AF, T)
