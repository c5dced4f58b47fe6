# SPDX-License-Identifier: MIT
"""What holds for every format: files whole or not at all, known names, no boat that runs away; the command."""

from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from conftest import TABLE_II, make_model
from export_tools import BOATS, boat

import seatrial
from seatrial.commands import make_parser
from seatrial.commands.cli import main
from seatrial.export import FORMATS, Hull, export
from seatrial.export.content import Content
from seatrial.export.spelling import identifier
from seatrial.util.errors import ExportError, ModelError
from seatrial.util.files import read_yaml
from seatrial.util.frames import Axes

HULL = Hull(10.0, 0.5, (0.6, 0.5, 0.2))
TEXT = [name for name, chosen in FORMATS.items() if name not in {"fmu", "casadi"}]


@pytest.fixture(autouse=True)
def no_compiler(monkeypatch):
    """The unit's own tests compile it."""
    monkeypatch.setenv("CC", "no-such-compiler")


def written(folder: Path, name: str, model: seatrial.Model) -> Path:
    if name == "casadi":
        pytest.importorskip("casadi")
    out = folder / f"boat{FORMATS[name].suffix}"
    export(model, name, out, model_path="model.yaml", hull=HULL)
    return out


@pytest.mark.parametrize("name", FORMATS)
def test_a_file_begins_as_its_kind_does_and_is_the_same_again(tmp_path, name):
    first = written(tmp_path, name, boat("always_forward")).read_bytes()
    assert first.startswith(FORMATS[name].begins.encode())
    assert written(tmp_path, name, boat("always_forward")).read_bytes() == first
    assert [p.name for p in tmp_path.iterdir()] == [f"boat{FORMATS[name].suffix}"]


@pytest.mark.parametrize("name", TEXT)
def test_text_has_the_boats_name_and_axes_and_where_it_is_from(tmp_path, name):
    model = boat("right_down") if name != "sdf" else boat("always_forward")
    text = written(tmp_path, name, model).read_text()
    assert "mallard" in text
    assert f"seatrial {version('seatrial')}" in text
    assert name == "sdf" or "forward-right-down" in text
    assert str(Path.home()) not in text.replace(str(Path.cwd()), "")


@pytest.mark.parametrize("name", [n for n, chosen in FORMATS.items() if chosen.runs])
def test_a_model_that_runs_away_is_refused_where_it_is_to_run(tmp_path, name):
    away = make_model(
        seatrial.load_vehicle("mallard-mp"), TABLE_II["AF"] | {"X_u": 0.5, "X_uu": 0.0}
    )
    with pytest.raises(ModelError, match="the model is unstable: driven in surge"):
        written(tmp_path, name, away)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", FORMATS)
def test_a_name_of_another_kind_is_refused(tmp_path, name):
    with pytest.raises(
        ExportError, match=rf"boat\.doc: expected a name that ends in \{FORMATS[name].suffix}"
    ):
        export(boat("always_forward"), name, tmp_path / "boat.doc", hull=HULL)


@pytest.mark.parametrize("name", BOATS)
def test_in_its_vehicles_axes_a_boat_is_the_model_file(tmp_path, name):
    """Values as `save` writes them, which is another way to turn them; T and T+ undo each other."""
    model = boat(name)
    seatrial.save(model, tmp_path / "model.yaml")
    saved = read_yaml(tmp_path / "model.yaml")
    content = Content(model)
    for kind in ("coefficients", "constants"):
        for parameter, entry in saved[kind].items():
            assert content.values[parameter] == pytest.approx(entry["value"], rel=1e-9)
            assert content.units[parameter] == entry["unit"]
    assert content.structure.lines() == saved["structure"]
    np.testing.assert_allclose(content.covariance, saved["covariance"], rtol=1e-8, atol=1e-15)
    if model.vehicle.file.thrusters:
        np.testing.assert_allclose(content.mix @ content.inverse, np.eye(3), atol=1e-12)
    inside = Content(model, Axes.FLU)
    assert inside.values == {
        **model.values, **dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True))
    }  # fmt: skip


@pytest.mark.parametrize(
    ("stem", "name"),
    [
        ("boat", "boat"),
        ("my-boat 2", "my_boat_2"),
        ("2nd", "boat_2nd"),
        ("double", "boat_double"),
        ("end", "boat_end"),
    ],
)
def test_names_in_programs(stem, name):
    assert identifier(stem) == name
    with pytest.raises(ExportError, match="can't be a name in a program"):
        identifier("--")


@pytest.fixture
def model_file(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    seatrial.save(boat("always_forward"), tmp_path / "model.yaml")
    return tmp_path / "model.yaml"


def command(*arguments: object) -> int:
    return main(["export", *map(str, arguments), "-q"])


def test_the_command_writes_what_the_function_does(tmp_path, model_file, capsys):
    out = tmp_path / "boat.h"
    assert command(model_file, "--to", "c", "-o", out) == 0
    assert (
        capsys.readouterr().out
        == f"wrote {out}: self-contained C99 header\nnext: use {out}  (how to call it: docs/export.md)\n"
    )
    export(seatrial.load(model_file), "c", tmp_path / "library" / "boat.h")
    assert out.read_text() == (tmp_path / "library" / "boat.h").read_text()
    assert command(model_file, "--to", "c", "-o", out, "--vehicle", "mallard-mp") == 0
    assert "double alpha" in out.read_text()
    assert "fmax(" not in out.read_text()  # no longer always-forward


def test_hull_and_ros_reach_their_formats(tmp_path, model_file):
    hull = ("--mass", 10, "--inertia", 0.5, "--size", 0.6, 0.5, 0.2, "--added-mass", 1, 2, 0.1)
    assert command(model_file, "--to", "sdf", "-o", tmp_path / "boat.sdf", *hull) == 0
    assert "<yDotV>-2.0</yDotV>" in (tmp_path / "boat.sdf").read_text()
    for ros in (1, 2):
        assert (
            command(model_file, "--to", "ros", "--ros", ros, "-o", tmp_path / f"ros{ros}.yaml") == 0
        )
        assert (tmp_path / f"ros{ros}.yaml").read_text().startswith(f"# ROS {ros} parameters")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--to", "simulink", "-o", "boat.slx"), "no format 'simulink'; there are c, octave, fmu, sdf, casadi, ros"),
        (("--to", "sdf", "-o", "boat.sdf"), "give mass, inertia and the hull's size"),
        (("--to", "sdf", "-o", "boat.sdf", "--mass", "10"), "--inertia, --size missing"),
        (("--to", "sdf", "-o", "boat.sdf", "--mass", "0", "--inertia", "1", "--size", "1", "1", "1"), "mass 0: expected a positive"),
        (("--to", "c", "-o", "taken.h"), "exists, and is not a file of this kind"),
        (("--to", "json", "-o", "model.yaml"), "is an input of this command"),
        (("--to", "c", "-o", "+.h"), "can't be a name in a program"),
    ],
)  # fmt: skip
def test_mistakes_are_one_line_and_leave_nothing(tmp_path, model_file, capsys, arguments, words):
    Path("taken.h").write_text("#pragma once\n")
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    assert command(model_file, *arguments) == 1
    shown = capsys.readouterr()
    assert words in shown.err
    assert shown.err.count("\n") == 1
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_the_help_names_every_format():
    export_parser = make_parser()._subparsers._group_actions[0].choices["export"]
    export_parser.fill()
    shown = next(a.help for a in export_parser._actions if a.dest == "to")
    assert [name for name in FORMATS if name not in shown] == []
