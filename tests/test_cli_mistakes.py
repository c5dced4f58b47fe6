# SPDX-License-Identifier: MIT
"""Every usual mistake at the command line: one clear line, nothing written, nothing lost."""

import re
import shutil

import numpy as np
import pytest
import yaml
from cli_tools import main, refused, run
from conftest import CSE1, make_model
from sheets import sheet
from survey_boat import TRUTH, boat

from seatrial.boat.model_file import load, save

BAD = {
    "no such recording": (["identify", "none", "--vehicle", "{v}", "-o", "{o}"], "no such file or folder"),
    "no such vehicle": (["identify", "{p}/S1-AF", "--vehicle", "none.yaml", "-o", "{o}"], "no such file"),
    "too short": (["identify", "{p}/S7-AF", "--vehicle", "{v}", "--end", "2", "-o", "{o}"], "2.0 s in all is too short|1.9 s in all is too short"),
    "outside": (["identify", "{p}/S7-AF", "--vehicle", "{v}", "--start", "900", "-o", "{o}"], "it lasts"),
    "cut at nan": (["identify", "{p}/S7-AF", "--vehicle", "{v}", "--start", "nan", "-o", "{o}"], "can't cut at nan s"),
    "cut at inf": (["identify", "{p}/S7-AF", "--vehicle", "{v}", "--end", "inf", "-o", "{o}"], "can't cut at inf s"),
    "cut backwards": (["inspect", "{p}/S7-AF", "--vehicle", "{v}", "--start", "20", "--end", "10"], "end 10 s is not after"),
    "cut without a vehicle": (["inspect", "{p}/S7-AF", "--without", "S7-AF=1-2"], "say with --vehicle"),
    "negative seed": (["simulate", "--seed", "-3", "-o", "{o}"], "seed"),
    "degrees": (["identify", "{p}/degrees", "--vehicle", "{v}", "-o", "{o}"], "is psi in degrees"),
    "millimetres": (["identify", "{p}/mm", "--vehicle", "{v}", "-o", "{o}"], "are x and y in mm"),
    "axis never excited": (["identify", "{p}/surge", "--vehicle", "{v}", "-o", "{o}"], "sway is never excited"),
    "no commands": (["identify", "{p}/mute", "--vehicle", "{v}", "-o", "{o}"], "has a header but no rows"),
    "not a number": (["identify", "{p}/nan", "--vehicle", "{v}", "-o", "{o}"], "empty or not finite"),
    "singular regressor": (["identify", "{p}/brief", "--vehicle", "{p}/twins.yaml", "-o", "{o}"], "X_a, X_b can't be told"),
    "unknown key": (["identify", "{p}/S7-AF", "--vehicle", "{p}/key.yaml", "-o", "{o}"], "unknown key 'axis'; did you mean"),
    "wrong unit": (["identify", "{p}/S7-AF", "--vehicle", "{p}/unit.yaml", "-o", "{o}"], "unit 'rad'; use m, cm, mm"),
    "no such unit": (["inspect", "{p}/S7-AF", "--vehicle", "{p}/furlong.yaml"], "pose.x"),
    "wrong role": (["identify", "{p}/S7-AF", "--vehicle", "{v}", "--role", "heave=S7-AF", "-o", "{o}"], "--role"),
    "unknown role": (["identify", "{p}/S7-AF", "--vehicle", "{v}", "--role", "yaw=S9", "-o", "{o}", "--method", "equation-error"], "no such recording"),
    "role of the other method": (["identify", "{p}/S7-AF", "--vehicle", "{v}", "--role", "yaw=S7-AF", "-o", "{o}"], "uses every recording for all axes; for roles, --method equation-error"),
    "twice": (["identify", "{p}/S7-AF", "{p}/S7-AF", "--vehicle", "{v}", "-o", "{o}"], "given twice"),
    "copied": (
        ["identify", "{p}/S7-AF", "{p}/copied", "--vehicle", "{v}", "-o", "{o}"],
        "are one recording",
    ),
    "other version": (["validate", "{p}/new.yaml", "{p}/S7-AF", "--json", "{o}"], "says 'seatrial: model 9'"),
    "not a model": (["validate", "{v}", "{p}/S7-AF", "--json", "{o}"], "says .seatrial: vehicle 1.; expected"),
    "unstable": (["validate", "{p}/wild.yaml", "{p}/S7-AF", "--json", "{o}"], "unstable"),
    "other boat": (["validate", "{p}/model.yaml", "{c}", "--vehicle", "{cv}", "--json", "{o}"], "the model has"),
    "horizon": (["validate", "{p}/model.yaml", "{p}/S7-AF", "--horizon", "0.001", "--json", "{o}"], "longer one"),
    "endless horizon": (["validate", "{p}/model.yaml", "{p}/S7-AF", "--horizon", "nan", "--json", "{o}"], "horizon"),
    "figures without a page": (["compare", "{p}/model.yaml", "{p}/model.yaml", "--figures", "{o}"], "say where with -o"),
    "pictures without figures": (["report", "{p}/model.yaml", "{p}/S7-AF", "--png", "-o", "{o}"], "--figures FOLDER"),
    "negative horizon": (["report", "{p}/model.yaml", "{p}/S7-AF", "--horizon", "-1", "-o", "{o}"], "horizon"),
    "no plan": (["simulate", "--plan", "none", "-o", "{o}"], "one of clean, hard, lake, paper-like"),
    "read as, and nothing is read": (["compare", "{p}/model.yaml", "{p}/model.yaml", "--start", "0", "--salvage"], "--start and --salvage belong to recordings; none is given"),
    "of another boat, and nothing is read": (["compare", "{p}/model.yaml", "{p}/model.yaml", "--vehicle", "{v}", "--horizon", "2"], "--vehicle and --horizon belong to recordings"),
    "cut of nothing to allocate along": (["allocate", "{v}", "--without", "S1=2-3"], "--without belongs to recordings"),
    "horizon of other scores": (["report", "{p}/model.yaml", "{p}/S7-AF", "--scores", "{p}/s.json", "--horizon", "1", "-o", "{o}"], "--horizon belongs to scores that are computed here"),
    "live options along a recording": (["predict", "{p}/model.yaml", "{p}/S7-AF", "--adapt", "off", "--clock", "data", "-o", "{o}"], "--clock and --adapt belong to --live"),
    "cut of a stream": (["predict", "{p}/model.yaml", "--live", "--end", "3"], "--end belongs to recordings"),
    "hull of another format": (["export", "{p}/model.yaml", "--to", "c", "--mass", "0", "--added-mass", "1", "2", "3", "-o", "{o}.h"], "--mass and --added-mass belong to --to sdf"),
    "version of another format": (["export", "{p}/model.yaml", "--to", "json", "--ros", "2", "-o", "{o}.json"], "--ros belongs to --to ros"),
    "vehicle that the node does not read": (["export", "{p}/model.yaml", "--to", "ros", "--vehicle", "mallard-mp", "-o", "{o}.yaml"], "--vehicle belongs to the other formats; the node reads .*with_vehicle.*mallard-mp"),
    "unwritable": (["report", "{p}/model.yaml", "{p}/S7-AF", "-o", "{v}/x.html"], "can't be written"),
}  # fmt: skip


@pytest.fixture(scope="module")
def spoiled(pool):
    """The pool with things in it that are wrong."""
    for name in ("surge", "mute", "nan"):
        shutil.copytree(pool / "S1-AF", pool / name)
    shutil.copytree(pool / "S7-AF", pool / "copied")
    for name, factor in (("degrees", [1, 1, 1, 57.3]), ("mm", [1, 1000, 1000, 1])):
        shutil.copytree(pool / "S7-AF", pool / name)
        poses = np.loadtxt(pool / name / "poses.csv", delimiter=",", skiprows=1) * factor
        sheet(pool / name / "poses.csv", "t,x,y,psi", poses)
    (pool / "brief").mkdir()
    for name in ("poses.csv", "commands.csv"):  # a minute
        head, *rows = (pool / "S7-AF" / name).read_text().splitlines()
        first = float(rows[0].split(",")[0])
        rows = [row for row in rows if float(row.split(",")[0]) < first + 60.0]
        (pool / "brief" / name).write_text("\n".join([head, *rows]) + "\n")
    sticks = (pool / "surge" / "commands.csv").read_text().splitlines()
    rows = [sticks[0], *(",".join([*line.split(",")[:2], "0", "0"]) for line in sticks[1:])]
    (pool / "surge" / "commands.csv").write_text("\n".join(rows))
    (pool / "mute" / "commands.csv").write_text(sticks[0] + "\n")
    (pool / "nan" / "commands.csv").write_text(
        "\n".join([*sticks[:50], "0.5,nan,0,0", *sticks[50:]])
    )
    vehicle = (pool / "vehicle-AF.yaml").read_text()
    spoil = {
        "twins": (
            "structure: mallard",
            "structure: {surge: [X_a * u, X_b * u, X_F * F_u], sway: [Y_F * F_v], yaw: [N_F * F_r]}",
        ),
        "key": ("axes:", "axis: up\naxes:"),
        "unit": ("{column: x}", "{column: x, unit: rad}"),
        "furlong": ("{column: x}", "{column: x, unit: furlong}"),
    }
    for name, (old, new) in spoil.items():
        assert old in vehicle
        (pool / f"{name}.yaml").write_text(vehicle.replace(old, new, 1))
    content = yaml.safe_load((pool / "model.yaml").read_text())
    (pool / "new.yaml").write_text(yaml.safe_dump(content | {"seatrial": "model 9"}))
    content["coefficients"]["X_u"]["value"] = 5.0
    content["coefficients"]["X_uu"]["value"] = 1.0
    (pool / "wild.yaml").write_text(yaml.safe_dump(content))
    return pool


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_is_one_line_exit_1_and_nothing_written(case, spoiled, tmp_path, capsys):
    template, words = BAD[case]
    out = tmp_path / "out"
    names = {
        "p": spoiled, "v": spoiled / "vehicle-AF.yaml", "o": out, "cv": CSE1 / "vehicle.yaml",
        "c": CSE1 / "csv" / "CSE1_data_run1.csv",
    }  # fmt: skip
    err = refused(capsys, *(a.format(**names) for a in template))
    assert err.startswith("seatrial: ")
    assert re.search(words, err), err
    assert not out.exists()
    assert list(tmp_path.iterdir()) == []


def test_a_copy_of_a_recording_is_refused(pool, tmp_path, capsys):
    shutil.copytree(pool / "S1-AF", tmp_path / "S1-AF")
    err = refused(
        capsys, "identify", pool / "S1-AF", tmp_path / "S1-AF", "--vehicle", pool / "vehicle-AF.yaml",
        "-o", tmp_path / "m.yaml",
    )  # fmt: skip
    assert re.search(r"/S1-AF and \S+/S1-AF are one recording, \d+ poses", err), err


def test_two_recordings_of_one_name_are_told_apart_by_their_folders(pool, tmp_path, capsys):
    for k in (1, 2):
        shutil.copytree(pool / f"S{k}-AF", tmp_path / f"day{k}" / "run")
    model = tmp_path / "m.yaml"
    code, *_ = run(
        capsys, "identify", tmp_path / "day1" / "run", tmp_path / "day2" / "run",
        "--vehicle", pool / "vehicle-AF.yaml", "-o", model,
    )  # fmt: skip
    assert code == 0
    assert [entry.name for entry in load(model).recordings] == ["day1/run", "day2/run"]


def test_no_command_writes_over_its_inputs_or_over_other_files(pool, tmp_path, capsys):
    bag = pool / "S1-AF"
    vehicle = tmp_path / "v.yaml"
    vehicle.write_text((pool / "vehicle-AF.yaml").read_text())
    before = {p: p.read_bytes() for p in (vehicle, bag / "poses.csv")}
    model = tmp_path / "m.yaml"
    trials = [*(pool / f"S{i}-AF" for i in (1, 2, 3)), "--method", "equation-error"]
    assert run(capsys, "identify", *trials, "--vehicle", vehicle, "-o", model)[0] == 0
    for command in (
        ["identify", *trials, "--vehicle", vehicle, "-o", vehicle],
        ["identify", *trials, "--vehicle", vehicle, "-o", bag / "poses.csv"],
        ["inspect", bag, "--vehicle", vehicle, "--json", vehicle],
        ["validate", model, bag, "--json", model],
        ["report", model, bag, "-o", model],
        ["compare", model, model, "-o", model],
        ["report", model, bag, "-o", bag],
        ["report", model, bag, "-o", tmp_path],
        ["init", bag / "poses.csv", "-o", bag / "poses.csv", "--force"],
        ["predict", model, bag, "-o", bag / "poses.csv"],
        ["predict", model, bag, "-o", bag / "commands.csv"],
    ):
        err = refused(capsys, *command)
        assert "give another name" in err or "is a folder" in err
    assert {p: p.read_bytes() for p in before} == before
    assert (
        run(capsys, "identify", *trials, "--vehicle", vehicle, "-o", model)[0] == 0
    )  # a model over a model


def test_simulated_trials_write_over_simulated_ones_only(tmp_path, capsys):
    out = tmp_path / "trials"
    plan = tmp_path / "plan.yaml"
    plan.write_text(
        "seatrial: plan 1\nbased_on: clean\nvehicles: [mallard-mp]\ntrials: {S1: {drive: surge, duration: 12}}\n"
    )
    mine = out / "S1-MP" / "poses.csv"
    mine.parent.mkdir(parents=True)
    mine.write_text("t,x,y,psi\n")
    assert "was not simulated" in refused(capsys, "simulate", "--plan", plan, "-o", out)
    assert mine.read_text() == "t,x,y,psi\n"
    assert sorted(p.name for p in out.rglob("*")) == ["S1-MP", "poses.csv"]
    mine.unlink()
    mine.parent.rmdir()
    for _ in range(2):
        assert run(capsys, "simulate", "--plan", plan, "-o", out)[0] == 0
    for edited in (out / "vehicle-MP.yaml", mine):
        kept = edited.read_bytes()
        edited.write_bytes(kept + b"\n")
        before = {p: p.read_bytes() for p in out.rglob("*") if p.is_file()}
        err = refused(capsys, "simulate", "--plan", plan, "-o", out)
        assert f"{edited}: was edited since" in err
        assert {p: p.read_bytes() for p in out.rglob("*") if p.is_file()} == before
        edited.write_bytes(kept)
    assert run(capsys, "simulate", "--plan", plan, "-o", out, "--format", "bag")[0] == 0


def test_the_papers_misprint_is_not_asked_of_another_method(pool, tmp_path, capsys):
    assert "belongs to equation-error" in refused(
        capsys, "identify", pool / "S1-AF", "--vehicle", pool / "vehicle-AF.yaml", "--literal",
        "--method", "output-error", "-o", tmp_path / "m.yaml",
    )  # fmt: skip


def test_a_recording_in_place_of_a_model_is_said_to_be_a_folder(pool, capsys):
    err = refused(capsys, "validate", pool / "S1-AF", pool / "vehicle-AF.yaml")
    assert "S1-AF: is a folder; expected a YAML file: is it a recording?" in err


def test_recordings_that_may_be_left_out_are_not_required(capsys):
    with pytest.raises(SystemExit):
        main(["compare", "old.yaml"])
    assert "the following arguments are required: B;" in capsys.readouterr().err


def test_a_boat_without_sway_thrust_is_refused_a_plan_with_it_before_trials_are_written(
    tmp_path, capsys
):
    out = tmp_path / "trials"
    model = tmp_path / "model.yaml"
    save(make_model(boat(), TRUTH), model)
    err = refused(capsys, "simulate", "--plan", "hard", "--model", model, "-o", out)
    assert "trial S2 of plan hard drives sway" in err
    assert not out.exists()
