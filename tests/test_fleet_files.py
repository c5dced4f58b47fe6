# SPDX-License-Identifier: MIT
"""Files and folders of a fleet: kinds and options of its boats, names that are no names, links, one run at a time."""

from pathlib import Path

import msgspec
import pytest
from cli_tools import done, refused
from test_fleet_kinds import made_up
from test_many_boats import config, rows

from seatrial.fleet.fleet import fleet
from seatrial.fleet.fleet_file import load_fleet
from seatrial.util.errors import FleetError, SeatrialError
from seatrial.util.parallel import InTurn

EVIL = "<img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def boats(tmp_path_factory):
    """Three boats with a table each, where it matters little what was recorded."""
    root = tmp_path_factory.mktemp("fleet") / "boats"
    for name in ("ada", "bea", "cid"):
        (root / name).mkdir(parents=True)
        (root / name / "run.csv").write_text("t,x\n0,1\n")
        (root / name / "vehicle.yaml").touch()
    return root


def test_a_file_names_kinds_vehicles_and_options(boats, tmp_path):
    found = load_fleet(
        config(
            tmp_path / "fleet.yaml",
            f"""\
seatrial: fleet 1
name: harbour
vehicle: mallard-mp
identify: {{effects: [lever]}}
boats:
  zoe:
    kind: heavy
    recordings: [{boats}/ada/S1-MP, {boats}/ada/S2-MP]
    test: S2-MP
  abe: {{recordings: [{boats}/bea/S1-MP], vehicle: {boats}/bea/vehicle-MP.yaml, identify: {{salvage: true}}}}
  ../evil: {{recordings: [x]}}
""",
        )
    )
    assert [one.name for one in found.boats] == ["../evil", "abe", "zoe"]
    evil, abe, zoe = found.boats
    assert "can't be a folder's" in evil.refused
    assert (abe.kind, zoe.kind, zoe.test) == ("harbour", "heavy", "S2-MP")
    assert zoe.options.effects == ("lever",) and abe.options.salvage
    assert zoe.vehicle == Path("mallard-mp") and zoe.recordings[0] == boats / "ada" / "S1-MP"
    result = fleet(found, tmp_path / "out", _Never()).result
    assert set(result.failed) == {"../evil", "abe", "zoe"}
    assert not (tmp_path / "evil").exists() and rows(result)["../evil"].report is None


class _Never(InTurn):
    """Workers without memory."""

    def outcomes(self, work, common, items):
        for place, _ in enumerate(items):
            yield place, MemoryError(EVIL)


def test_a_second_run_in_the_same_folder_is_refused_until_the_first_ends(tmp_path):
    fcntl = pytest.importorskip("fcntl")
    odd = tmp_path / "boats"
    (odd / "ada").mkdir(parents=True)
    (tmp_path / "out").mkdir()
    with (tmp_path / "out" / ".lock").open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(FleetError, match="another 'seatrial fleet' works on this folder"):
            fleet(load_fleet(odd), tmp_path / "out")
    assert fleet(load_fleet(odd), tmp_path / "out").result.failed == ["ada"]
    (tmp_path / "file").touch()
    with pytest.raises(SeatrialError, match="can't be written"):
        fleet(load_fleet(odd), tmp_path / "file" / "out")


class _Elsewhere(InTurn):
    """Workers with a disk of their own."""

    def outcomes(self, work, common, items):
        for place, one in enumerate(items):
            yield place, msgspec.structs.replace(made_up(one.name, 1.0), kind=one.kind)


def test_results_that_stay_on_the_workers_are_no_results(boats, tmp_path):
    result = fleet(load_fleet(boats), tmp_path / "out", _Elsewhere()).result
    assert result.failed == ["ada", "bea", "cid"]
    assert "this computer does not see" in rows(result)["ada"].result.error


def test_names_and_errors_are_escaped_in_the_page(boats, tmp_path):
    odd = tmp_path / "boats"
    (odd / EVIL).mkdir(parents=True)
    fleet(load_fleet(odd), tmp_path / "out")
    assert EVIL not in (tmp_path / "out" / "fleet.html").read_text()
    fleet(load_fleet(boats), tmp_path / "out2", _Never())
    page = (tmp_path / "out2" / "fleet.html").read_text()
    assert EVIL not in page and "seatrial failed: MemoryError: &lt;img" in page


def test_links_out_of_the_folder_are_refused(boats, tmp_path):
    (tmp_path / "fleet" / "eve").mkdir(parents=True)
    (tmp_path / "fleet" / "eve" / "S1").symlink_to(boats / "ada")
    (tmp_path / "fleet" / "vehicle.yaml").write_text("x")
    (found,) = load_fleet(tmp_path / "fleet").boats
    assert "link out of the fleet's folder" in found.refused


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("seatrial: fleet 1\nboats: {}\n", "no boats"),
        ("seatrial: fleet 2\nboats: {}\n", "expected 'seatrial: fleet 1'"),
        ("seatrial: fleet 1\nboats: {a: {recordings: [x], vehicel: y}}\n", "vehicel"),
        ("seatrial: fleet 1\nidentify: {effects: [fish]}\nboats: {a: {recordings: [x]}}\n", "fish"),
    ],
)
def test_a_wrong_file_is_one_line(tmp_path, text, words):
    with pytest.raises(SeatrialError, match=words):
        load_fleet(config(tmp_path / "fleet.yaml", text))


def test_simulated_seeds_are_a_fleet(tmp_path, capsys):
    plan = config(tmp_path / "plan.yaml", "seatrial: plan 1\nbased_on: clean\nname: short\n"
                  "trials: {S1: {drive: surge, duration: 10}}\n")  # fmt: skip
    out = tmp_path / "boats"
    words = ("--vehicle", "mallard-mp", "--seeds", 3, "--seed", 9, "-o", out)
    assert f"seatrial fleet {out}" in done(capsys, "simulate", "--plan", plan, *words)
    found = load_fleet(out)
    assert [one.name for one in found.boats] == ["seed-09", "seed-10", "seed-11"]
    assert [[r.name for r in one.recordings] for one in found.boats] == [["S1-MP"]] * 3
    paths = {(one.recordings[0] / "poses.csv").read_bytes() for one in found.boats}
    assert len(paths) == 3
    refused(capsys, "simulate", "--plan", plan, "--seeds", 0, "-o", out)


def test_command_prints_the_table_and_refuses_what_it_would_spoil(boats, tmp_path, capsys):
    one = tmp_path / "small"
    one.mkdir()
    (one / "ada").symlink_to(boats / "cid")
    refused(capsys, "fleet", boats, "--workers", 0, "-o", boats / "in", "--json", "-")
    text = done(capsys, "fleet", one, "--workers", 0, "-o", tmp_path / "out")
    assert "0 of 1 boats have a model" in text
    assert "\nada: run.csv is a link out of the fleet's folder" in text
    for words, wrong in (
        ("no results of a fleet", ("--last-time", tmp_path)),
        ("has the results of last time", ("--last-time", tmp_path / "out")),
    ):
        (tmp_path / "out" / "boats").mkdir(exist_ok=True)
        given = ("fleet", one, "--workers", 0, "-o", tmp_path / "out", *wrong)
        assert words in refused(capsys, *given)
