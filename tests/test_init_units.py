# SPDX-License-Identifier: MIT
"""A proposal for recordings in other units and axes."""

import numpy as np
import pytest
import yaml
from conftest import at_length
from init_tools import same_boat, tables, with_papers_terms
from logs import drive, half
from test_model import frd

import seatrial
from seatrial.commands.cli import main
from seatrial.inspection.consistency.check import check_consistency


def test_degrees_and_millimetres_are_noticed(log, tmp_path, propose):
    other = log.but(pose=log.pose * [1000.0, 1000.0, 180 / np.pi])
    folder = tables(other, tmp_path / "pool")
    vehicle, text = propose(folder)
    pose = yaml.safe_load(text)["pose"]
    assert (pose["x"], pose["y"]) == ({"column": "x", "unit": "mm"}, {"column": "y", "unit": "mm"})
    assert pose["psi"] == {"column": "psi", "unit": "deg"}
    for said in ("x is in mm", "y is in mm", "psi is in deg"):
        assert f"# {said}, by the motion of the boat" in text
    record = seatrial.read(folder, vehicle)
    np.testing.assert_allclose(record.eta, log.pose, atol=1e-9)


@pytest.mark.parametrize(
    "case",
    [
        ("t [ms],X [cm],Y [cm],yaw [deg]", "time_ms,a,b,c", 1e3, ("ms", "cm", "deg")),
        ("stamp,pos_x,pos_y,heading", "ns,a,b,c", 1e9, ("ns", None, None)),
        ("time,x_mm,y_mm,psi_deg", "t,a,b,c", 1e6, ("us", "mm", "deg")),
        ("seconds;x;y;theta".replace(";", ","), "t,a,b,c", 1.0, (None, None, None)),
    ],
)
def test_units_in_the_names_of_columns_are_believed(log, tmp_path, propose, case):
    pose, commands, second, units = case
    scale = {None: 1.0, "cm": 100.0, "mm": 1000.0, "deg": 180 / np.pi}
    other = log.but(pose=log.pose * [scale[units[1]], scale[units[1]], scale[units[2]]])
    folder = tables(other, tmp_path / "pool", pose=pose, commands=commands, second=second)
    vehicle, text = propose(folder)
    content = yaml.safe_load(text)
    assert content["pose"]["stamp"].get("unit") == units[0]
    assert content["commands"]["stamp"].get("unit") == units[0]
    assert content["pose"]["x"].get("unit") == units[1]
    assert content["pose"]["psi"].get("unit") == units[2]
    record = seatrial.read(folder, vehicle)
    np.testing.assert_allclose(record.eta, log.pose, atol=1e-9)
    np.testing.assert_allclose(record.t, log.pose_t, atol=1e-6)
    assert [e["column"] for e in content["commands"]["inputs"].values()] == ["a", "b", "c"]


@pytest.mark.parametrize("sticks", ["turned", at_length("as they were")])
def test_a_recording_in_forward_right_down_axes(tmp_path, propose, sticks):
    """The same boat; sticks that are positive to port have sign -1 in a file that is to starboard."""
    log = drive(120.0, sticks=half)
    turned = np.array([1.0, -1.0, -1.0])
    other = log.but(
        pose=log.pose * turned, command=log.command * (turned if sticks == "turned" else 1.0)
    )
    path = other.write(tmp_path / "pool.bag")
    vehicle, text = propose(path, "--axes", "forward-right-down")
    assert "axes: forward-right-down" in text
    assert "y to starboard, psi clockwise" in text
    inputs = yaml.safe_load(text)["commands"]["inputs"]
    assert [e.get("sign", 1) for e in inputs.values()] == (
        [1, 1, 1] if sticks == "turned" else [1, -1, -1]
    )
    record = seatrial.read(path, vehicle)
    np.testing.assert_allclose(record.commands.values, log.command, atol=1e-6)
    assert check_consistency([record], vehicle).findings == ()
    right = frd(seatrial.load_vehicle("mallard-mp"))
    left = log.write(tmp_path / "left.bag")
    port, _ = propose(left)
    reference = seatrial.identify([seatrial.read(left, port)], with_papers_terms(port))
    model = seatrial.identify([record], with_papers_terms(vehicle))
    np.testing.assert_allclose(model.coefficients, reference.coefficients, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(model.constants, reference.constants, rtol=1e-4, atol=1e-5)
    assert right.axes is vehicle.axes


def test_pulse_widths_to_starboard(log, tmp_path, propose):
    """A file's own axes and its offset are two things: neither is turned with the other."""
    turned = np.array([1.0, -1.0, -1.0])
    other = log.but(pose=log.pose * turned, command=1500 + 400 * log.command * turned)
    folder = tables(other, tmp_path / "pool")
    vehicle, text = propose(folder, "--axes", "forward-right-down")
    for entry in yaml.safe_load(text)["commands"]["inputs"].values():
        assert (entry["offset"], entry["scale"]) == (1500, 400)
    np.testing.assert_allclose(
        seatrial.read(folder, vehicle).commands.values, log.command, atol=1e-9
    )


@pytest.mark.system
def test_several_recordings_show_together_what_one_does_not(tmp_path, propose):
    """One axis each, as the paper's S1 to S3."""
    paths = [
        drive(seed=i, sticks=lambda t, seed, i=i: half(t, seed) * np.eye(3)[i]).write(tmp_path / f"S{i + 1}.bag")
        for i in range(3)
    ]  # fmt: skip
    _, alone = propose(paths[0])
    assert [*yaml.safe_load(alone)["commands"]["inputs"]] == ["F_u"]
    out = tmp_path / "all.yaml"
    assert main(["init", *map(str, paths), "-o", str(out), "-q"]) == 0
    content = yaml.safe_load(out.read_text())
    assert {n: e["field"] for n, e in content["commands"]["inputs"].items()} == {
        "F_u": "axes[1]", "F_v": "axes[0]", "F_r": "axes[3]",
    }  # fmt: skip
    vehicle = seatrial.load_vehicle(out)
    records = [seatrial.read(path, vehicle) for path in paths]
    assert check_consistency(records, vehicle).findings == ()
    right = seatrial.load_vehicle("mallard-mp")
    expected = seatrial.identify([seatrial.read(path, right) for path in paths], right)
    same_boat(seatrial.identify(records, with_papers_terms(vehicle)), expected)


def test_columns_named_north_and_east_have_their_place_in_each_axes(log, tmp_path, propose):
    """With a heading clockwise from north, as the columns are read: x is the log's first column, north."""
    folder = tables(log, tmp_path / "pool", pose="t,north,east,heading")
    vehicle, text = propose(folder)
    assert "x is east and y is north" in text
    record = seatrial.read(folder, vehicle)
    np.testing.assert_allclose(record.eta[:, :2], log.pose[:, [1, 0]], atol=1e-9)
    turned = np.exp(1j * (np.pi / 2 - log.pose[:, 2]))
    np.testing.assert_allclose(np.exp(1j * record.eta[:, 2]), turned, atol=1e-6)
    vehicle, text = propose(folder, "--axes", "forward-right-down", "--force")
    assert "x is north and y is east" in text
    record = seatrial.read(folder, vehicle)
    np.testing.assert_allclose(record.eta, log.pose * [1, -1, -1], atol=1e-9)
