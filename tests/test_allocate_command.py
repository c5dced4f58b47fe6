# SPDX-License-Identifier: MIT
"""`seatrial allocate`: schemes side by side on a recorded drive, as text, JSON and a page."""

import json
from pathlib import Path

import numpy as np
import pytest
from cli_tools import done, refused, run
from html_tables import Tables
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from sheets import sheet

import seatrial
from seatrial import _core
from seatrial.control.allocation import compare_schemes, effectiveness, load_boat
from seatrial.control.allocation.page.draw import outline
from seatrial.control.allocation.schemes import PLAIN, RECORDED, crossings

ROOT = Path(__file__).resolve().parents[1]
ZONE = 0.1
FILE = """
chain:
  - dead_zone: {forward: 0.1, reverse: 0.1}
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A vehicle file with a dead zone, and a drive: sticks of a minute, fifty times a second."""
    folder = tmp_path_factory.mktemp("allocate")
    from importlib import resources

    text = (resources.files("seatrial") / "data" / "vehicles" / "mallard-mp.yaml").read_text()
    (folder / "vehicle.yaml").write_text(text + FILE)
    t = np.arange(0.0, 60.0, 0.02)
    sticks = np.column_stack(
        [0.9 * np.sin(0.5 * t), 0.4 * np.sin(0.31 * t), 0.3 * np.round(np.sin(0.9 * t))]
    )
    run = folder / "drive"
    run.mkdir()
    sheet(run / "commands.csv", "t,F_u,F_v,F_r", t, sticks, form="%.6f")
    poses = np.column_stack([t, 0.1 * t, 0 * t, 0.01 * t])[::3]
    sheet(run / "poses.csv", "t,x,y,psi", poses, form="%.6f")
    return folder


@pytest.fixture(scope="module")
def compared(place):
    vehicle = seatrial.load_vehicle(place / "vehicle.yaml")
    recording = seatrial.read(place / "drive", vehicle)
    return compare_schemes(vehicle, [recording]), recording


@given(
    commands=arrays(float, (30, 2), elements=st.sampled_from([-0.5, -0.2, -0.05, 0.0, 0.1, 0.3]))
)
def test_crossings_are_counted_one_by_one(commands):
    edges = np.array([[0.1, 0.0], [0.2, 0.0]])
    want = [0, 0]
    for k in range(2):
        last = None
        for c in commands[:, k]:
            now = (
                "ahead"
                if c >= edges[0, k] and c != 0
                else "astern"
                if c <= -edges[1, k] and c != 0
                else "inside"
            )
            if last in ("ahead", "astern") and now != last:
                want[k] += 1
            last = now
    assert crossings(commands, edges).tolist() == want


def test_plain_moore_penrose_loses_what_the_dead_zone_takes(compared):
    found, recording = compared
    drive = found.row(PLAIN).drives[0]
    F = recording.commands.values
    vehicle = found.boat.vehicle
    f, alpha = _core.allocate(vehicle.chain, F)
    assert np.all(alpha == 1.0)
    given = np.sign(f) * np.maximum(0.0, np.abs(f) - ZONE) / (1 - ZONE) @ vehicle.mix.T
    np.testing.assert_allclose(drive.error, np.sqrt(np.mean((given - F) ** 2, axis=0)), rtol=1e-9)
    np.testing.assert_allclose(drive.requested, np.sqrt(np.mean(F**2, axis=0)), rtol=1e-9)
    thrust = np.maximum(0.0, np.abs(f) - ZONE) / (1 - ZONE)
    assert drive.power == pytest.approx(np.mean(np.sum(thrust**1.5, axis=1)), rel=1e-9)
    recorded = found.row(RECORDED).drives[0]
    assert recorded.crossing == pytest.approx(drive.crossing)
    assert recorded.minutes == pytest.approx(len(F) * 0.02 / 60.0)


def test_the_schemes_differ_as_they_should(compared):
    found, _ = compared
    by_name = {row.name: row for row in found.rows}
    assert found.allocator.scheme.value == "moore-penrose"  # no wrench error, and the least power
    assert "fewest-crossings" not in by_name  # it is null-space here
    drives = {name: row.drives[0] for name, row in by_name.items()}
    assert drives["always-forward"].crossing == drives["null-space"].crossing == 0.0
    assert 0 < drives["sign-pattern"].crossing < drives["moore-penrose"].crossing
    assert drives["moore-penrose"].error_share < 1e-12 < drives[PLAIN].error_share
    assert drives["null-space"].limited < drives["always-forward"].limited
    assert drives["null-space"].error_share < drives["always-forward"].error_share
    # S = 2 T: one axis takes two thrusters of Table I, idling at the edge plus 0.04
    idle = 0.04 / (1 - ZONE)
    np.testing.assert_allclose(by_name["always-forward"].authority, 1 - idle, rtol=1e-12)
    np.testing.assert_allclose(by_name["moore-penrose"].authority, 2.0, rtol=1e-12)
    assert by_name["null-space"].idle_power == pytest.approx(4 * idle**1.5)


def test_an_outline_is_the_edge_of_what_is_given(compared):
    found, _ = compared
    allocator = found.row("null-space").allocator
    x, y = outline(allocator, 0, 1)
    edge = np.column_stack([x, y, 0 * x])
    for share, out in ((0.999, False), (1.001, True)):
        _, shares, _ = allocator.allot(share * edge)
        assert np.all((shares.min(axis=1) < 1) == out)


def test_a_recorded_wrench_is_that_of_recorded_thruster_commands(cse1, cse1_vehicle):
    """Direct commands: T times the thrusts, which the core's own right-hand side gets, too."""
    from conftest import make_model

    values = {name: 0.1 * (i + 1) for i, name in enumerate(cse1_vehicle.structure.coefficients)}
    model = make_model(cse1_vehicle, values)
    own = effectiveness(model)
    recording = cse1["run1"]
    asked = own.requested_wrench(recording)
    np.testing.assert_allclose(asked, recording.commands.values @ own.T.T, atol=1e-12)
    found = compare_schemes(model, [recording])
    assert found.row(RECORDED).drives[0].error_share < 1e-12
    assert np.array_equal(own.sent_commands(recording), recording.commands.values)


def test_the_command_prints_writes_and_draws(place, capsys):
    out, data, figures, tables = (place / n for n in ("a.html", "a.json", "figures", "tables"))
    text = done(
        capsys, "allocate", place / "vehicle.yaml", place / "drive", "-o", out, "--json", data,
        "--figures", figures, "--tables", tables,
    )  # fmt: skip
    assert "scheme: moore-penrose: least wrench error, then least power: least thrust" in text
    found = json.loads(data.read_text(), parse_constant=pytest.fail)
    assert found["chosen"] == "moore-penrose"
    assert found["thrusters"]["F_3"] == {
        "effectiveness": [pytest.approx(0.5), pytest.approx(0.5), pytest.approx(-0.5)],
        "dead_zone": {"forward": 0.1, "reverse": 0.1},
        "limit": 1.0,
    }
    page = Tables(out.read_text())
    (rows,) = page.found["drive-0"]
    shown = {row[0][0]: row for row in rows[1:]}
    for scheme in found["schemes"]:
        (drive,) = scheme["drives"]
        crossing = sum(drive["crossings_per_minute"].values())
        assert shown[scheme["scheme"]][1][1] == [pytest.approx(crossing)]
        assert f"{crossing:15.1f}" in next(
            line
            for line in text.split("drive, ")[1].splitlines()
            if line.startswith(f"  {scheme['scheme']} ")
        )
    assert "http" not in out.read_text().split("</head>")[0].replace("http-equiv", "")
    names = {p.name for p in figures.iterdir()}
    assert {"reach-surge-sway.svg", "reach-surge-yaw.svg", "reach-sway-yaw.svg"} < names
    assert {p.name for p in tables.iterdir()} >= {"authority.csv", "idle.csv", "drive-0.csv"}


def test_the_command_gives_the_commands_for_one_wrench(place, capsys):
    code, text, _ = run(
        capsys,
        "allocate",
        place / "vehicle.yaml",
        "--wrench",
        0.2,
        0.1,
        -0.3,
        "--scheme",
        "moore-penrose",
    )
    assert code == 0
    assert text.splitlines()[0] == "moore-penrose: F_u 0.2, F_v 0.1, F_r -0.3"
    shown = [float(line.split()[1]) for line in text.splitlines()[1:]]
    y = np.linalg.pinv(seatrial.load_vehicle("mallard-mp").mix) @ [0.2, 0.1, -0.3]
    want = np.where(np.abs(y) < 1e-12, 0.0, np.sign(y) * (ZONE + (1 - ZONE) * np.abs(y)))
    np.testing.assert_allclose(shown, want, atol=5e-5)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["mallard-mp", "--wrench", "5", "0", "0"], "wrench 5, 0, 0: moore-penrose reaches"),
        (["mallard-mp", "--priority", "yaw"], "priority 'yaw': name surge, sway and yaw once each"),
        (["mallard-mp", "--margin", "2"], "leave no room below the limit 1"),
        (["nowhere.yaml"], "nowhere.yaml: no such file"),
        (["mallard-mp", "--vehicle", "mallard-af"], "is a vehicle itself"),
        (["mallard-mp", "--figures", "x"], "--figures and --tables belong to the HTML file"),
    ],
)
def test_mistakes_are_one_line(arguments, says, capsys):
    assert says in refused(capsys, "allocate", *arguments)


def test_a_model_file_is_told_from_a_vehicle_file(place, tmp_path):
    from conftest import TABLE_II, make_model

    vehicle = seatrial.load_vehicle(place / "vehicle.yaml")
    seatrial.save(make_model(vehicle, TABLE_II["MP"]), tmp_path / "model.yaml")
    boat, reads = load_boat(tmp_path / "model.yaml")
    assert isinstance(boat, seatrial.Model)
    assert reads == boat.vehicle
    assert seatrial.Allocator(boat).edges.tolist() == [[ZONE] * 4] * 2
    assert load_boat("mallard-af")[0] == seatrial.load_vehicle("mallard-af")


@pytest.mark.parametrize("name", ["mallard", "geometries"])
def test_the_pages_tables_are_what_the_benchmark_prints(name, tmp_path):
    from benchmarks.harness.page import csv_of, refill
    from benchmarks.studies.allocation import drives, geometries

    made = {"mallard": drives.mallard, "geometries": geometries.table_of_boats}[name]()
    page, copy = ROOT / "docs" / "allocate.md", tmp_path / "allocate.md"
    (tmp_path / "tables").mkdir()
    copy.write_text(page.read_text())
    refill(copy, {name: made})
    assert copy.read_text() == page.read_text()
    for written in (tmp_path / "tables").iterdir():
        assert written.read_text() == csv_of(page, name).read_text()
