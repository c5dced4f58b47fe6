# SPDX-License-Identifier: MIT
"""Exports of a boat with hostile names: they compile, compute what the boat with plain names does, and do nothing else."""

import ctypes
import json
import re
import subprocess
import zipfile
from xml.etree import ElementTree as Xml

import export_names
import numpy as np
import pytest
import yaml
from conftest import TABLE_II, at_length, make_model, on_request
from export_tools import program, run

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.export import Hull, export
from seatrial.export.content import Content
from seatrial.export.spelling import KEYWORDS, c_comment, identifiers, matlab_text, xml_comment
from seatrial.util.errors import ExportError

FEW, MANY, MORE = range(6), range(6, 20), range(20, 100)  # each piece of a name is in the first 12
SEEDS = [*FEW, *map(at_length, MANY), *map(on_request, MORE)]
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wshadow")
HULL = Hull(10.0, 0.5, (0.6, 0.5, 0.2))
PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")
DRIVE = """
#include <stdio.h>
#include "{name}.h"
int main(void) {{
  static {name}_boat own;
  const double command[] = {{0.7, 0.4, -0.6}};
  int i;
  {name}_reset(&own);
  own.scale[0] = 2.5;
  if (!{name}_command(&own, command)) return 1;
  for (i = 0; i < 40; ++i) if (!{name}_step(&own, 0.05)) return 2;
  for (i = 0; i < {upper}_STATES; ++i) printf("%.17g ", own.x[i]);
  return 0;
}}
"""


def driven_in_c(model: seatrial.Model, folder, name: str = "boat") -> list[float]:
    folder.mkdir()
    export(model, "c", folder / f"{name}.h")
    (folder / "main.c").write_text(DRIVE.format(name=name, upper=name.upper()))
    run("cc", *STRICT, "-o", "drive", "main.c", "-lm", cwd=folder)
    found = [float(x) for x in run("./drive", cwd=folder).split()]
    assert not (folder / export_names.PROOF).exists()
    return found


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> list[float]:
    """Where the boat with plain names goes."""
    program("cc")
    found = driven_in_c(export_names.plain_boat(), tmp_path_factory.mktemp("plain") / "c")
    assert np.abs(found).min() > 0.01
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_the_c_header_compiles_and_moves_the_boat(tmp_path, monkeypatch, plain, seed):
    found = driven_in_c(export_names.hostile_boat(seed, monkeypatch), tmp_path / "odd")
    assert found == plain


@pytest.mark.parametrize("name", ["BOAT", "F", "A", "X", "latency"])
def test_a_headers_own_names_and_the_models_do_not_meet(tmp_path, plain, name):
    model = export_names.boat("b", "abc", ("F_u", "F_X_u", "F_latency"), ("of", "of_2", ""), "s")
    assert driven_in_c(model, tmp_path / "odd", name) == plain


@pytest.mark.parametrize("seed", SEEDS)
def test_the_fmu_loads_and_its_description_is_xml(tmp_path, monkeypatch, seed):
    program("cc")
    monkeypatch.chdir(tmp_path)
    export(export_names.hostile_boat(seed, monkeypatch), "fmu", tmp_path / "boat.fmu")
    with zipfile.ZipFile(tmp_path / "boat.fmu") as archive:
        archive.extractall(tmp_path)
    for library in tmp_path.glob("binaries/*/*"):
        ctypes.CDLL(str(library))  # runs what a constructor would
    assert not list(tmp_path.rglob(export_names.PROOF))
    root = Xml.parse(tmp_path / "modelDescription.xml").getroot()
    names = [v.get("name") for v in root.find("ModelVariables")]
    assert len({*names}) == len(names) == 3 + 1 + 6 + 6 + 3
    assert all(map(PLAIN.fullmatch, names))


def test_fmpy_finds_nothing_wrong_with_hostile_names(tmp_path, monkeypatch):
    validation = pytest.importorskip("fmpy.validation")
    export(export_names.hostile_boat(3, monkeypatch), "fmu", tmp_path / "boat.fmu")
    assert validation.validate_fmu(str(tmp_path / "boat.fmu")) == []


@pytest.mark.system
def test_octave_runs_it_and_nothing_else(tmp_path, monkeypatch, plain):
    program("octave-cli")
    lines = ["1;"]
    seeds = range(40)
    for seed in seeds:
        export(export_names.hostile_boat(seed, monkeypatch), "octave", tmp_path / f"boat_{seed}.m")
    export(export_names.plain_boat(), "octave", tmp_path / "plain.m")
    for name in ("plain", *(f"boat_{seed}" for seed in seeds)):
        lines += [
            f"b = {name}(); s = b.reset(); s.scale = 2.5; s = b.command(s, [0.7; 0.4; -0.6]);",
            "for i = 1:40, s = b.step(s, 0.05); end", "printf('%.17g ', s.x); printf('\\n');",
            "try, b.command(s, 1); catch e, printf('%s\\n', strrep(e.message, \"\\n\", ' ')); end",
        ]  # fmt: skip
    (tmp_path / "script.m").write_text("\n".join(lines) + "\n")
    shown = run("octave-cli", "--no-init-file", "--quiet", "script.m", cwd=tmp_path).splitlines()
    for seed, states, message in zip((None, *seeds), shown[::2], shown[1::2], strict=True):
        np.testing.assert_allclose(
            [float(x) for x in states.split()], plain, rtol=1e-9, err_msg=str(seed)
        )
        assert "a command is 3 finite numbers: " in message
    assert not (tmp_path / export_names.PROOF).exists()


@pytest.mark.parametrize("seed", SEEDS)
def test_data_formats_read_back(tmp_path, monkeypatch, seed):
    model = export_names.hostile_boat(seed, monkeypatch)
    own = Content(model)
    for ros in (1, 2):
        export(model, "ros", tmp_path / "boat.yaml", model_path="model.yaml", ros=ros)
        text = (tmp_path / "boat.yaml").read_text()
        read = yaml.safe_load(text)["seatrial_odometry"]
        read = read["ros__parameters"] if ros == 2 else read
        assert [*read] == ["model", "boat"]
        assert read["boat"]["name"] == own.vehicle_name
        assert read["boat"]["inputs"] == [*own.inputs]
        assert all(map(PLAIN.fullmatch, read["boat"]["constants"]))
        assert [*read["boat"]["constants"].values()] == pytest.approx(model.constants.tolist())
    export(model, "json", tmp_path / "boat.json")
    read = json.loads((tmp_path / "boat.json").read_text())
    assert read["name"] == model.name
    assert [a["name"] for a in read["actuators"]] == [*model.vehicle.actuators]
    export(model, "latex", tmp_path / "boat.tex")
    text = (tmp_path / "boat.tex").read_text()
    assert "\\input{" not in text
    assert (
        text.count("\\end{align*}") == text.count("\\begin{tabular}") == text.count("\\end{tabular}") == 1
    )  # fmt: skip
    assert all(ord(c) > 31 or c == "\n" for c in text)


@pytest.mark.parametrize("seed", SEEDS)
def test_gazebos_model_is_xml_with_plain_unique_names(tmp_path, monkeypatch, seed):
    model = export_names.hostile_boat(seed, monkeypatch)
    try:
        export(model, "sdf", tmp_path / "boat.sdf", hull=HULL)
    except ExportError as error:  # a yaw thruster is no thruster in Gazebo
        assert "gives a moment without a force" in str(error)
        vehicle = seatrial.load_vehicle("mallard-mp")
        own = vehicle.to_mapping()
        names = [*model.vehicle.inputs, "joint"][:4]
        own["thrusters"] = dict(zip(names, own["thrusters"].values(), strict=True))
        export(
            make_model(vehicle_from(own, "odd"), TABLE_II["AF"]),
            "sdf",
            tmp_path / "boat.sdf",
            hull=HULL,
        )
    root = Xml.parse(tmp_path / "boat.sdf").getroot().find("model")
    names = [part.get("name") for kind in ("link", "joint") for part in root.findall(kind)]
    assert len({*names}) == len(names) == 9
    assert all(map(PLAIN.fullmatch, names))


def test_casadi_functions_are_the_same_for_any_names(tmp_path, monkeypatch):
    casadi = pytest.importorskip("casadi")
    found = []
    for model in (
        export_names.plain_boat(),
        *(export_names.hostile_boat(s, monkeypatch) for s in FEW),
    ):
        export(model, "casadi", tmp_path / "boat.casadi")
        rate = casadi.Function.load(str(tmp_path / "boat.casadi"))
        found.append(np.array(rate([0, 0, 0.3, 0.5, 0.1, 0.2], [0.7, 0.4, -0.6])))
    assert np.abs(found[0]).min() > 0.01
    assert all(np.array_equal(found[0], other) for other in found)


def test_identifiers():
    assert identifiers(["bow-thruster", "bow_thruster", "lag.bow", "2", "é", "日本", "_a", "int", "a" * 70, "a" * 71]) == {
        "bow-thruster": "bow_thruster", "bow_thruster": "bow_thruster_2", "lag.bow": "lag_bow", "2": "n_2", "é": "e",
        "日本": "n_", "_a": "n_a", "int": "int_2", "a" * 70: "a" * 63, "a" * 71: "a" * 61 + "_2",
    }  # fmt: skip
    assert identifiers(["x"], {"x", "x_2"}) == {"x": "x_3"}
    assert not {*identifiers(KEYWORDS).values()} & KEYWORDS


def test_texts_stay_texts():
    assert c_comment("a */ b /* c **/// ??/") == "a * / b / * c * * / / / ? ?/"
    assert matlab_text("it's 100 %d\n\\n") == "it''s 100 %%d \\\\n"
    assert xml_comment("--> --- -") == "- -> - - - "


@pytest.mark.parametrize("name", ["step", "rate", "zeros", "max", "curves", "end"])
def test_an_octave_function_is_not_called_as_one_that_it_calls(tmp_path, name):
    with pytest.raises(ExportError, match=f"name it boat_{name}.m"):
        export(export_names.plain_boat(), "octave", tmp_path / f"{name}.m")


def test_the_boat_of_the_issue(tmp_path, plain):
    """A group called bow-thruster: exit 0 and C that does not compile, once."""
    model = export_names.boat("b", ("bow-thruster", "bow_thruster", "x"), ("F_u", "F_v", "F_r"),
                              ("bow-thruster", "bow_thruster", ""), "s")  # fmt: skip
    assert driven_in_c(model, tmp_path / "odd") == plain
    text = (tmp_path / "odd" / "boat.h").read_text()
    assert "BOAT_lag_bow_thruster " in text
    assert "BOAT_lag_bow_thruster_2 " in text


def test_the_compiler_is_not_called_by_a_shell(tmp_path, monkeypatch):
    called = []
    real = subprocess.run
    monkeypatch.setattr(subprocess, "run", lambda *a, **k: called.append((a, k)) or real(*a, **k))
    program("cc")
    export(export_names.plain_boat(), "fmu", tmp_path / "a; touch b.fmu")
    assert called
    assert not any(k.get("shell") for _, k in called)
    assert not (tmp_path / "b.fmu").exists()
