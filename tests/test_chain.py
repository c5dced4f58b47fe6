# SPDX-License-Identifier: MIT
"""The actuator chain in the vehicle file: pairs of commands, and constants that are to be estimated."""

import csv

import numpy as np
import pytest
from conftest import CSE1, TABLE_II, make_model
from hypothesis import given
from hypothesis import strategies as st

import seatrial
from seatrial import _core
from seatrial.boat.findings import FindingKind, finding_of, of_kinds
from seatrial.boat.model_file import load, save
from seatrial.boat.schema import ChainGroup
from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.identification.estimator import output_error
from seatrial.identification.selection.actuator_stages import with_estimated_stages, with_room
from seatrial.simulation.trials import plant_model
from seatrial.util.errors import IdentificationError, SeatrialError, VehicleError
from seatrial.util.files import convert
from seatrial.util.frames import AXES
from tests.boats.hulls import MIDDLE, driven
from tests.boats.motions import recorded, states_at
from tests.boats.plans import planned
from tests.boats.vehicles import by_columns

ACROSS, DEAD = 0.16, 0.22  # [-] offset and dead zone of the made-up propellers
PAIR = {
    "of": [["left_surge", "left_sway"], ["right_surge", "right_sway"]],
    "mirrored": ["right_sway"],
    "offset": {"across": ACROSS},
    "dead_zone": DEAD,
}
INPUTS = ("left_surge", "left_sway", "right_surge", "right_sway")


def tug(axes="forward-left-up", pair=PAIR, inputs=INPUTS, **chain) -> Vehicle:
    """Two Voith-Schneider propellers side by side."""
    surge, sway = inputs[0::2], inputs[1::2]
    forces = {
        "F_u": {"axis": "surge", "of": dict.fromkeys(surge, 0.5)},
        "F_v": {"axis": "sway", "of": dict.fromkeys(sway, 0.5)},
        "F_r": {"axis": "yaw", "of": dict(zip(surge, (-0.5, 0.5), strict=False))},
    }
    structure = {
        "surge": ["v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
        "sway": ["-1 * u * r", "Y_v * v", "Y_vv * |v| * v", "Y_F * F_v"],
        "yaw": ["N_r * r", "N_rr * |r| * r", "N_F * F_r", "N_v * F_v"],
    }
    stages = [{"pair": pair, **chain}]
    return by_columns("tug", inputs, structure, axes=axes, forces=forces, chain=stages)


def forces(vehicle: Vehicle, rows: np.ndarray) -> np.ndarray:
    """Generalised forces of rows of commands that are a second apart, in the vehicle's own axes."""
    chain, q = vehicle.chain, vehicle.constants.values
    read = rows * vehicle.input_signs
    outputs = [_core.curve(chain, q, k, np.ascontiguousarray(read)) for k in range(rows.shape[1])]
    return np.stack(outputs, axis=1) @ vehicle.mix.T


def by_hand(rows: np.ndarray) -> np.ndarray:
    """The same of the tug, from the definition with complex numbers."""
    out = []
    for along, across, mirror in ((0, 1, 1.0), (2, 3, -1.0)):
        P = rows[:, along] + 1j * (mirror * rows[:, across] + ACROSS)
        size = np.clip((np.abs(P) - DEAD) / (1 - DEAD), 0.0, 1.0)
        thrust = size * np.exp(1j * np.angle(P))
        out.append((thrust.real, mirror * thrust.imag))
    (x1, y1), (x2, y2) = out
    return np.stack([(x1 + x2) / 2, (y1 + y2) / 2, (x2 - x1) / 2], axis=1)


COMMANDS = st.lists(
    st.lists(st.floats(-1.2, 1.2), min_size=4, max_size=4), min_size=1, max_size=5
).map(np.array)


@given(COMMANDS)
def test_a_pairs_thrust_is_along_the_vector_of_its_two_commands(rows):
    np.testing.assert_allclose(forces(tug(), rows), by_hand(rows), atol=1e-12)


@given(COMMANDS)
def test_offset_and_mirror_are_of_the_commands_as_the_file_has_them(rows):
    """Commands keep their sign in either axes, forces to the side and in yaw change theirs."""
    flipped = forces(tug("forward-right-down"), rows)
    np.testing.assert_allclose(flipped, by_hand(rows) * [1.0, -1.0, -1.0], atol=1e-12)


@given(st.lists(st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2)), min_size=1).map(np.array))
def test_a_pair_of_wrench_inputs_is_turned_with_them(rows):
    """A boat with one propeller whose commands are F_u and F_v, in forward-right-down axes."""
    pair = {**PAIR, "of": [["F_u", "F_v"]], "mirrored": []}
    one = tug("forward-right-down", pair, ("F_u", "F_v"))
    P = rows[:, 0] + 1j * (rows[:, 1] + ACROSS)
    thrust = np.clip((np.abs(P) - DEAD) / (1 - DEAD), 0.0, 1.0) * np.exp(1j * np.angle(P))
    wanted = 0.5 * np.stack([thrust.real, -thrust.imag], axis=1)
    np.testing.assert_allclose(forces(one, rows)[:, :2], wanted, atol=1e-12)


@pytest.mark.parametrize(
    ("pair", "more", "words"),
    [
        ({"of": [["left_surge", "left_sway"], ["left_surge", "right_sway"]]}, {}, "left_surge named"),
        ({"of": []}, {}, "no actuator named"),
        ({"of": [["left_surge", "stern"]]}, {}, "names 'stern'; the actuators are left_surge"),
        ({"of": [["left_surge", "left_sway"]], "mirrored": ["right_sway"]}, {}, "mirrored names right"),
        (PAIR, {"dead_zone": {"forward": 0.1, "reverse": 0.1}}, "stands instead of dead_zone"),
        (PAIR, {"power": "estimate"}, "stands instead of dead_zone"),
        (PAIR, {"table": [[-1, -1], [1, 1]]}, "instead of dead_zone, power, reverse_ratio and table"),
        ({**PAIR, "dead_zone": 1.0}, {}, "dead_zone"),
        ({**PAIR, "dead_zone": "sought"}, {}, "sought"),
    ],
)  # fmt: skip
def test_a_pair_that_is_none_is_one_clear_line(pair, more, words):
    with pytest.raises(SeatrialError, match=words) as caught:
        tug(pair=pair, **more)
    assert "\n" not in str(caught.value)


def test_what_is_to_be_estimated_has_a_start_value():
    group = {
        "latency": "estimate", "dead_zone": "estimate", "reverse_ratio": "estimate",
        "power": "estimate", "lag": "estimate",
    }  # fmt: skip
    boat = seatrial.load_vehicle("mallard-mp").with_chain([convert(group, ChainGroup, "chain")])
    names = ("latency", "edge_forward", "edge_reverse", "reverse_ratio", "power", "lag")
    assert boat.estimated == boat.constants.names == names
    assert boat.constants.values.tolist() == [0.0, 0.05, 0.05, 1.0, 1.0, 0.05]
    values = dict(zip(names, (0.1, 0.07, 0.09, 0.8, 1.2, 0.2), strict=True))
    known = boat.with_stated(values)
    assert known.estimated == ()
    assert dict(zip(known.constants.names, known.constants.values, strict=True)) == values


def test_a_model_keeps_what_was_estimated_and_states_it_on_request(tmp_path):
    estimated = {**PAIR, "offset": {"across": "estimate"}, "dead_zone": "estimate"}
    boat = tug("forward-right-down", estimated, latency="estimate", lag=0.1)
    assert boat.estimated == ("latency", "pair_offset_across", "pair_dead_zone")
    values = dict.fromkeys(boat.structure.coefficients, -0.2)
    model = make_model(boat, values)
    found = np.array([0.3, 0.1, ACROSS, DEAD])
    model = seatrial.Model(
        boat, model.coefficients, model.covariance, found, model.integration, model.noise,
        model.envelope,
    )  # fmt: skip
    save(model, tmp_path / "model.yaml")
    back = load(tmp_path / "model.yaml")
    assert back.vehicle.file == boat.file
    np.testing.assert_array_equal(back.constants, found)
    assert back.known_vehicle.estimated == ()
    np.testing.assert_array_equal(back.known_vehicle.constants.values, found)


def ship(vehicle: Vehicle) -> Vehicle:
    """The real ship, with the power of its propellers' speed left open."""
    propellers = {
        "name": "propellers", "actuators": [n for n in vehicle.actuators if n != "bow"],
        "scale": {"signal": "propeller_speed", "power": "estimate"},
    }  # fmt: skip
    return vehicle.with_chain([convert(propellers, ChainGroup, "chain")])


def test_equation_error_and_simulated_truths_take_numbers_only(mp, cse1, cse1_vehicle):
    with pytest.raises(
        IdentificationError,
        match=r"'estimate' is given for .*scale_power\.propellers; equation-error",
    ):
        seatrial.identify([cse1["run1"]], ship(cse1_vehicle), method="equation-error")
    open_latency = convert({"latency": "estimate"}, ChainGroup, "chain")
    unknown = planned("clean", plant={"chain": [open_latency]})
    with pytest.raises(VehicleError, match="leaves latency to be estimated; give numbers"):
        plant_model(unknown, mp)


def test_a_scales_power_is_taken_as_2_where_the_signal_hardly_changes(cse1, cse1_vehicle):
    open_power = ship(cse1_vehicle)
    assert "scale_power.propellers" in open_power.estimated
    whole, findings = with_estimated_stages(open_power, [cse1["random_run1"], cse1["random_run3"]])
    assert "scale_power.propellers" not in whole.estimated
    constants = dict(zip(whole.constants.names, whole.constants.values, strict=True))
    assert constants["scale_power.propellers"] == 2.0
    names = "scale_power.propellers", "propeller_speed"
    assert finding_of(FindingKind.SCALE_POWER_HELD, *names, power=2.0) in findings
    assert np.ptp(cse1["run1"].scales.values) > 0.1  # before there was a command
    assert (
        "scale_power.propellers"
        not in with_estimated_stages(open_power, [cse1["run1"]])[0].estimated
    )
    whole, findings = with_estimated_stages(open_power, [cse1["random_run1"], cse1["run1"]])
    assert "scale_power.propellers" in whole.estimated
    assert not of_kinds(findings, FindingKind.SCALE_POWER_HELD)


def test_the_real_propellers_bollard_pulls_have_a_pairs_shape():
    """Least squares of offset and dead zone on pulls along and across leave less than a line does."""
    ship = seatrial.load_vehicle(CSE1 / "pair.yaml")
    with (CSE1 / "tow_and_bollard_summary.csv").open() as file:
        table = list(csv.DictReader(file))
    for group, k in (("VSPsurge", 0), ("VSPsway", 1)):
        pulls = [(float(r["value"]), float(r["force_N"])) for r in table if r["group"] == group]
        x, y = np.array(pulls).T
        rows = np.zeros((len(x), 5))
        rows[:, k] = x / 0.95  # where the file has the limit
        q = {"pair_offset_across.propellers": 0.2, "pair_dead_zone.propellers": 0.29}
        known = ship.with_stated(q)
        g = _core.curve(known.chain, known.constants.values, k, rows)
        bent = y - g * (g @ y) / (g @ g)
        straight = y - np.polyval(np.polyfit(x, y, 1), x)
        assert np.sqrt(np.mean(bent**2)) < 0.7 * np.sqrt(np.mean(straight**2))


def test_offset_and_dead_zone_of_a_pair_are_found_on_the_way():
    """A noisy run of the tug, its propellers known but for the pair's constants."""
    rng = np.random.default_rng(20)
    truth = tug(latency=0.2, lag=0.05)
    values = {**TABLE_II["MP"], "N_v": -0.4}
    boat = make_model(truth, {n: values[n] for n in truth.structure.coefficients}, step=1 / 30)
    t_c, t = np.arange(0.0, 300.0, 2.0), np.arange(0.0, 300.0, 0.1)
    commands = t_c, rng.uniform(-1, 1, (len(t_c), 4))
    poses = states_at(boat, t, *commands)[:, :3]
    noisy = poses + rng.normal(0.0, 1.0, poses.shape) * [2e-3, 2e-3, 4e-3]  # [m], [m], [rad]
    run = recorded("run", truth, (t, noisy), commands)
    pair = {**PAIR, "offset": {"along": 0.0, "across": "estimate"}, "dead_zone": "estimate"}
    model = output_error([run], tug(pair=pair, latency="estimate", lag=0.05))
    found = dict(zip(model.vehicle.constants.names, model.constants, strict=True))
    errors = model.standard_errors
    for name, value in (("pair_offset_across", ACROSS), ("pair_dead_zone", DEAD), ("latency", 0.2)):
        assert abs(found[name] - value) < 4 * errors[name]
        assert errors[name] < 0.02
    assert found["pair_offset_along"] == 0.0
    assert errors["pair_offset_along"] == 0.0


def test_more_constants_than_the_core_takes_are_one_line():
    """And of a full chain no more is asked than there is room for."""
    names = [f"a{k}" for k in range(8)]
    structure = {"surge": ["X_u * u", *(f"X_{k} * F_{k}" for k in range(8))]}
    forces = {f"F_{k}": {"axis": "surge", "of": {n: 1.0}} for k, n in enumerate(names)}

    def eight(**own):
        chain = [{"name": f"g{k}", "actuators": [n], **own} for k, n in enumerate(names)]
        return by_columns("boat", names, structure, forces=forces, chain=chain)

    edges = {"dead_zone": {"forward": 0.1, "reverse": 0.1}}
    full = eight(latency=0.1, lag=0.1, **edges)
    assert len(full.constants.names) == _core.MAX_CONSTANTS
    with pytest.raises(VehicleError, match="40 constants of the chain; at most 32"):
        eight(latency=0.1, lag=0.1, power=1.2, **edges)
    one_more = ChainGroup(name="gain", gains={"a0": 1.0})
    assert with_room(full, [*full.file.chain, one_more]) is None
    assert with_room(eight(lag=0.1), [*eight(lag=0.1).file.chain, one_more]) is not None


def wrenches(axes, *groups):
    """A boat whose inputs are F_u, F_v and F_r themselves."""
    inputs = ("F_u", "F_v", "F_r")
    return by_columns("boat", inputs, "mallard", axes=axes, chain=list(groups))


@pytest.mark.parametrize(
    ("group", "stage"),
    [
        ({"reverse_ratio": 0.5}, "reverse_ratio"),
        ({"table": [[-1.0, -0.5], [0.0, 0.0], [1.0, 1.0]]}, "a table"),
    ],
)
def test_what_tells_full_forward_from_reverse_is_not_turned_around_with_the_axes(group, stage):
    """F_v of a forward-right-down file is turned when it is read: its reverse would be taken for forward."""
    with pytest.raises(
        VehicleError, match=f"chain: {stage} distinguishes .*F_v have the opposite sign"
    ):
        wrenches("forward-right-down", {"actuators": ["F_v"], **group})
    wrenches("forward-right-down", {"actuators": ["F_u"], **group})


@pytest.mark.parametrize("reverse", [0.02, "forward"])
def test_edges_are_of_the_commands_as_the_file_counts_them(reverse):
    """A command of 0.05 to starboard is + in a forward-right-down file, and - when it is read."""
    zone = {"dead_zone": {"forward": 0.1, "reverse": reverse}}
    boat = wrenches("forward-right-down", zone)
    rows = np.array([[0.05, 0.05, 0.05], [-0.05, -0.05, -0.05]])
    found = forces(boat, rows)
    np.testing.assert_allclose(found[0], 0.0, atol=0)
    past = 0.0 if reverse == "forward" else 0.03 / 0.98
    np.testing.assert_allclose(found[1], [-past, past, past])


@pytest.mark.system
def test_a_boat_whose_inputs_are_mixed_is_the_same_in_either_axes():
    """Each axis' edges are found; those of F_v and F_r count the other way in forward-right-down files."""
    _, recordings = driven(MIDDLE, {"lag": 0.15}, seed=3, white=2e-3, seconds=60.0)
    found = []
    for axes in ("forward-left-up", "forward-right-down"):
        content = wrenches(axes).to_mapping()
        forces = {
            f"F_{s}": {"axis": a, "of": {f"F_{s}": 1.0}} for s, a in zip("uvr", AXES, strict=True)
        }
        found.append(output_error(recordings, vehicle_from({**content, "forces": forces}, axes)))
    left, right = (
        dict(zip(m.parameters, [*m.coefficients, *m.constants], strict=True)) for m in found
    )
    assert "edge_reverse.dead_zone_F_r" in left
    other = {"forward": "reverse", "reverse": "forward"}
    for name, value in left.items():
        stage, _, group = name.partition(".")
        kind, _, side = stage.partition("_")
        turned = kind == "edge" and group in ("dead_zone_F_v", "dead_zone_F_r")
        twin = f"edge_{other[side]}.{group}" if turned else name
        assert right[twin] == pytest.approx(value, rel=1e-6, abs=1e-9), name
