# SPDX-License-Identifier: MIT
"""Names in vehicle and model files: what is a name, and what is refused in one line."""

from importlib import resources

import export_names
import msgspec
import pytest
from cli_tools import refused

import seatrial
from seatrial.boat.vehicle import load_vehicle, vehicle_from
from seatrial.simulation.plan import load_plan
from seatrial.util.errors import FileError, StructureError, VehicleError
from seatrial.util.files import dump_yaml, read_yaml

ODD = [
    "", " ", "a\nb", "a\x1b[31m", "a\x00", 'a"', "a'", "a;b", "a*/", "-a", "a ", "a" * 65, "\u202ea", "a\\b",
    "a$b", "a%",
]  # fmt: skip
KINDS = ("input", "thruster", "force", "chain group", "scale")


def content() -> dict:
    return load_vehicle("mallard-mp").to_mapping()


def named(kind: str, name: str) -> dict:
    """A vehicle file in which one thing is called so."""
    own = content()
    if kind == "thruster":
        first, *rest = own["thrusters"].items()
        own["thrusters"] = {name: first[1], **dict(rest)}
    elif kind == "chain group":
        own["chain"] = [{"name": name, "lag": 0.1}]
    elif kind == "scale":
        own["scales"] = {name: {"column": "n", "reference": 1.0}}
    else:
        own |= {"thrusters": {}, "allocation": {"scheme": "direct"}, "chain": []}
        inputs = {"F_u": {"column": "a"}, (name if kind == "input" else "b"): {"column": "b"}}
        own["commands"] = {**own["commands"], "inputs": inputs}
        own["forces"] = {f: {"axis": a, "of": {"F_u": 1.0}} for f, a in
                         (("F_u", "surge"), ("F_v", "sway"), ("F_r", "yaw"))}  # fmt: skip
        if kind == "force":
            own["forces"][name] = {"axis": "yaw", "of": {"b": 1.0}}
    return own


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", [n for n in ODD if n])
def test_what_is_no_word_is_no_name(kind, name):
    with pytest.raises(VehicleError, match=f"{kind} '.*a name has 1 to 64 letters"):
        vehicle_from(named(kind, name), "boat.yaml")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "name",
    ["bow-thruster", "bow_thruster", "Strahlruder Bb.", "motör 2", "左舷", "axes.1", "a/b", "1", "x" * 64],
)  # fmt: skip
def test_names_in_use_stay_names(kind, name):
    name = name.rstrip(".")
    vehicle_from(named(kind, f"F_{name}"[:64] if kind == "force" else name), "boat.yaml")


@pytest.mark.parametrize(
    "title", ["MallARD v2", "Ole's boat (2024)", "Möwe", "海鷗", 'a/b: <c> & "d"', "x" * 100]
)
def test_a_boats_name_is_any_line(title):
    assert vehicle_from(content() | {"name": title}, "boat.yaml").name == title


@pytest.mark.parametrize(
    "title", ["", " ", "a\nb", "a\x1b[2J", "\x00", "\u202eabc", "\ufeff", "x" * 101]
)
def test_a_boats_name_is_one_line(title):
    with pytest.raises(VehicleError, match=r"boat\.yaml: name '.*one line of 1 to 100 printable"):
        vehicle_from(content() | {"name": title}, "boat.yaml")


@pytest.mark.parametrize(
    "name", ["mallard\n", "../structures/mallard", "/etc/passwd", "a" * 5000, "..", "\x00"]
)
def test_a_structures_name_is_no_path(name):
    with pytest.raises(StructureError, match=r"no structure named '.{,40}'; there are mallard"):
        vehicle_from(content() | {"structure": name}, "boat.yaml")


def test_a_vehicles_name_of_any_length_is_one_line(tmp_path, capsys):
    assert "File name too long" in refused(capsys, "inspect", tmp_path, "--vehicle", "a" * 500)


def test_a_number_beyond_all_is_refused():
    own = content() | {"structure": {"surge": ["1e999 * X_u * u", "X_F * F_u"]}}
    with pytest.raises(StructureError, match=r"beyond 1\.8e308"):
        vehicle_from(own, "boat.yaml")


@pytest.mark.parametrize("kind", ["vehicle", "group"])
def test_a_models_names_are_checked_as_a_vehicles(tmp_path, capsys, kind):
    seatrial.save(export_names.plain_boat(), tmp_path / "model.yaml")
    own = read_yaml(tmp_path / "model.yaml")
    if kind == "vehicle":
        own["vehicle"]["name"] = f"*/\n{export_names.CREATES}/*"
    else:
        own["vehicle"]["chain"][0]["name"] = "'\n"
    (tmp_path / "model.yaml").write_text(dump_yaml(own))
    out = tmp_path / "boat.h"
    shown = refused(capsys, "export", tmp_path / "model.yaml", "--to", "c", "-o", out, "-q")
    assert "one line of 1 to 100" in shown if kind == "vehicle" else "a name has 1 to 64" in shown
    assert not out.exists()


OUTSIDE = [
    "/etc/passwd", "../poses.csv", "a/../../b.csv", "..", "\\\\host\\a.csv", "C:\\a.csv", "C:a.csv",
    "..\\a.csv", "a\x00b",
]  # fmt: skip


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.parametrize("place", ["pose", "commands", "x", "input", "scale"])
def test_a_file_is_one_of_the_recordings_folder(place, name):
    own = content()
    if place == "x":
        own["pose"]["x"] = {"column": "x", "file": name}
    elif place == "input":
        own["commands"]["inputs"]["F_u"] = {"column": "x", "file": name}
    elif place == "scale":
        own["scales"] = {"speed": {"column": {"column": "n", "file": name}, "reference": 1.0}}
    else:
        own[place]["file"] = name
    with pytest.raises(VehicleError, match="is not in the recording's folder; give a name in it"):
        vehicle_from(own, "boat.yaml")


@pytest.mark.parametrize("name", ["poses.csv", "logs/poses.csv", "a..b.csv", "..a.csv", "100%.csv"])
def test_files_in_the_folder_are_named(name):
    own = content()
    own["pose"]["file"] = name
    assert vehicle_from(own, "boat.yaml").file.pose.file == name


@pytest.mark.parametrize("name", ["../S1", "/tmp/S1", "a/b", "", ".hidden", "a\nb", "x" * 70])
def test_a_trial_is_a_name_of_files(tmp_path, name):
    plan = read_yaml(resources.files("seatrial") / "data" / "plans" / "clean.yaml")
    trial = next(iter(load_plan("clean").trials.values()))
    plan["trials"] = {name: msgspec.to_builtins(trial)}
    (tmp_path / "plan.yaml").write_text(dump_yaml(plan))
    with pytest.raises(FileError, match=r"plan\.yaml: trial '"):
        load_plan(tmp_path / "plan.yaml")
