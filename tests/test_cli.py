# SPDX-License-Identifier: MIT
"""The command line as a user meets it: every command, every usual mistake."""

import json

import numpy as np
import pytest
import yaml
from cli_tools import done, refused, run
from conftest import CSE1
from programs import PROGRAM, piped, printed

import seatrial
from seatrial.commands.cli import main

SHIP = [str(CSE1 / "csv" / "CSE1_data_random_run3.csv"), "--vehicle", str(CSE1 / "coupled.yaml")]


@pytest.mark.system
def test_the_line_from_recordings_to_a_report(pool, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(
        "seatrial.report.figures.png.SCALE", 0.5
    )  # how large a picture is: test_report_png
    trials = [pool / f"S{i}-AF" for i in range(1, 8)]
    vehicle = ["--vehicle", pool / "vehicle-AF.yaml"]
    out = done(capsys, "inspect", trials[0], *vehicle)
    assert "% of the effort is in surge: this recording identifies surge best" in out
    model = tmp_path / "model.yaml"
    out = done(capsys, "identify", *trials[:3], *vehicle, "-o", model)
    assert "X_F" in out
    assert "Compare with your boat." in out
    assert model.read_text() == (pool / "model.yaml").read_text()
    out = done(capsys, "validate", model, *trials[3:], "--json", tmp_path / "scores.json")
    scores = json.loads((tmp_path / "scores.json").read_text())
    assert [r["recording"] for r in scores["recordings"]] == ["S4-AF", "S5-AF", "S6-AF", "S7-AF"]
    for name in ("rms", "stays_constant", "floor", "excess"):
        assert f" {100 * scores['recordings'][0]['scores']['u'][name]:.3f}" in out, name
    out = done(capsys, "report", model, trials[3], "-o", tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")
    out = done(
        capsys, "report", model, trials[3], "-o", tmp_path / "report.html",
        "--figures", tmp_path / "figures", "--png", "--tables", tmp_path / "tables",
    )  # fmt: skip
    assert out.partition("\nnext: ")[0].split()[1:] == [
        f"{tmp_path / 'report.html'},", f"{tmp_path / 'figures'},", f"{tmp_path / 'tables'}",
    ]  # fmt: skip
    assert (tmp_path / "figures" / "known.svg").is_file()
    assert (tmp_path / "figures" / "known.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "tables" / "coefficients.csv").is_file()
    out = done(capsys, "compare", model, model, trials[3], "-o", tmp_path / "both.html")
    assert f"wrote {tmp_path / 'both.html'}\nnext: " in out
    assert "A and B" in (tmp_path / "both.html").read_text()


def test_inspect_without_a_vehicle_shows_the_columns(pool, tmp_path, capsys):
    out = done(capsys, "inspect", pool / "S1-AF", CSE1 / "csv" / "CSE1_data_run1.csv")
    assert "poses.csv: 1774 rows" in out
    assert "monotonic: stamps in s? 15 Hz" in out
    assert "monotonic: stamps in s? 20 Hz" in out
    assert "vsp_speed   0 to 0.3" in out
    assert "is an empty folder; expected a bag" in refused(capsys, "inspect", tmp_path)


def test_simulate_writes_trials_vehicle_and_truth(tmp_path, capsys):
    plan = tmp_path / "plan.yaml"
    plan.write_text(
        "seatrial: plan 1\nbased_on: hard\nseed: 7\ntrials: {S2: {drive: sway, duration: 30}}\n"
    )
    done(capsys, "simulate", "--plan", plan, "-o", tmp_path / "out")
    names = {
        str(p.relative_to(tmp_path / "out")) for p in (tmp_path / "out").rglob("*") if p.is_file()
    }
    assert names == {
        "vehicle-MP.yaml", "vehicle-AF.yaml", "truth/plan.yaml", "truth/model-MP.yaml",
        "truth/model-AF.yaml", "truth/S2-MP.csv", "truth/S2-AF.csv", "truth/written.json",
        "S2-MP/poses.csv", "S2-MP/commands.csv", "S2-AF/poses.csv", "S2-AF/commands.csv",
    }  # fmt: skip
    done(
        capsys, "simulate", "--plan", plan, "--vehicle", tmp_path / "out" / "vehicle-AF.yaml",
        "--model", tmp_path / "out" / "truth" / "model-AF.yaml", "--seed", 7, "-o", tmp_path / "again",
    )  # fmt: skip
    assert (tmp_path / "again" / "S2-AF" / "poses.csv").read_text() == (
        tmp_path / "out" / "S2-AF" / "poses.csv"
    ).read_text()


def test_start_and_end_cut_the_recording(pool, tmp_path, capsys):
    code, _, _ = run(
        capsys, "identify", pool / "S7-AF", "--vehicle", pool / "vehicle-AF.yaml",
        "--start", 60, "--end", 180, "-o", tmp_path / "m.yaml", "--method", "equation-error",
    )  # fmt: skip
    assert code == 0
    (entry,) = yaml.safe_load((tmp_path / "m.yaml").read_text())["recordings"]
    assert entry["length"] == pytest.approx(120, abs=0.2)
    assert entry["start"] == pytest.approx(60, abs=0.1)


def test_inspect_says_which_figures_are_from_before_the_cut(pool, capsys):
    arguments = ("inspect", pool / "S7-AF", "--vehicle", pool / "vehicle-AF.yaml")
    _, whole, _ = run(capsys, *arguments)
    _, part, _ = run(capsys, *arguments, "--end", 60)
    counted = [[line for line in out.splitlines() if " Hz" in line] for out in (whole, part)]
    assert len(counted[0]) == 2
    assert counted[1] == [f"{line}; before cutting" for line in counted[0]]


def test_a_spread_without_its_prior_is_refused(pool, tmp_path, capsys):
    code, _, err = run(
        capsys, "identify", pool / "S7-AF", "--vehicle", pool / "vehicle-AF.yaml",
        "-o", tmp_path / "m.yaml", "--prior-spread", 0.5,
    )  # fmt: skip
    assert (code, err) == (
        1,
        "seatrial: --prior-spread belongs to --prior OLD; no prior is given\n",
    )


def identified(capsys, recording, pool, folder):
    """What `identify` of one recording says with the pool's vehicle."""
    vehicle, out = pool / "vehicle-AF.yaml", folder / "m.yaml"
    return run(capsys, "identify", recording, "--vehicle", vehicle, "-o", out)


def test_of_a_recording_that_is_not_used_whole_it_is_said(pool, tmp_path, capsys):
    (tmp_path / "S7").mkdir()
    for name in ("poses.csv", "commands.csv"):
        lines = (pool / "S7-AF" / name).read_text().splitlines()
        lost = name == "commands.csv"
        kept = [t for t in lines[1:] if not (lost and 60.0 < float(t.partition(",")[0]) < 120.0)]
        (tmp_path / "S7" / name).write_text("\n".join([lines[0], *kept]) + "\n")
    code, out, _ = identified(capsys, tmp_path / "S7", pool, tmp_path)
    assert code == 0
    assert "doubt: S7: 25 % of its poses are left out; inspect says why" in out


def test_a_boat_that_stays_where_it_is_is_refused_by_its_name(pool, tmp_path, capsys):
    (tmp_path / "S7").mkdir()
    commands = (pool / "S7-AF" / "commands.csv").read_text()
    (tmp_path / "S7" / "commands.csv").write_text(commands)
    head, *rows = (pool / "S7-AF" / "poses.csv").read_text().splitlines()
    noise = np.random.default_rng(2).normal(0.0, 1e-3, (len(rows), 3))
    still = [
        ",".join([row.partition(",")[0], *map(str, n)]) for row, n in zip(rows, noise, strict=True)
    ]
    (tmp_path / "S7" / "poses.csv").write_text("\n".join([head, *still]) + "\n")
    code, _, err = identified(capsys, tmp_path / "S7", pool, tmp_path)
    assert code == 1
    assert "the boat is commanded but moves no more than its pose noise" in err


def test_init_names_all_recordings_it_looked_at(pool, tmp_path, capsys):
    trials = [pool / f"S{i}-AF" for i in (1, 2, 3)]
    out = done(capsys, "init", *trials, "-o", tmp_path / "v.yaml")
    assert "# Proposed by 'seatrial init' from S1-AF, S2-AF, S3-AF." in out


def test_swapped_inputs_are_a_doubt(pool, tmp_path, capsys):
    text = (pool / "vehicle-AF.yaml").read_text()
    swapped = text.replace("column: F_u", "column: F").replace("column: F_v", "column: F_u")
    swapped = swapped.replace("column: F,", "column: F_v,")
    assert swapped != text
    (tmp_path / "v.yaml").write_text(swapped)
    trials = [pool / f"S{i}-AF" for i in (1, 2, 3)]
    code, out, _ = run(
        capsys, "identify", *trials, "--vehicle", tmp_path / "v.yaml", "-o", tmp_path / "m.yaml",
        "--method", "equation-error", "-v",
    )  # fmt: skip
    assert code == 0
    assert "F_u does not significantly drive surge. Check for two inputs swapped" in out
    assert "F_v does not significantly drive sway" in out


def test_the_terminal_says_which_axes_and_what_the_file_negates(tmp_path, capsys):
    ship = [CSE1 / "csv" / "CSE1_data_random_run1.csv", "--vehicle", CSE1 / "vehicle.yaml"]
    paper = ["--method", "equation-error"]
    out = done(capsys, "identify", *ship, *paper, "-o", tmp_path / "m.yaml")
    assert "in forward-left-up axes; all from CSE1_data_random_run1:" in out
    model = seatrial.load(tmp_path / "m.yaml")
    written = yaml.safe_load((tmp_path / "m.yaml").read_text())["coefficients"]
    negated = [n for n, v in model.values.items() if v * written[n]["value"] < 0]
    assert negated == ["N_ud", "N_uu"]
    assert "The file is in forward-right-down axes: N_ud, N_uu negated." in out


def test_roles_can_be_given(pool, tmp_path, capsys):
    code, _, _ = run(
        capsys, "identify", pool / "S1-AF", pool / "S2-AF", pool / "S3-AF", pool / "S7-AF",
        "--vehicle", pool / "vehicle-AF.yaml", "--role", "yaw=S7-AF,S3-AF", "-o", tmp_path / "m.yaml",
        "--method", "equation-error",
    )  # fmt: skip
    assert code == 0
    steps = yaml.safe_load((tmp_path / "m.yaml").read_text())["estimator"]["steps"]
    assert steps[2]["recordings"] == ["S7-AF", "S3-AF"]


def test_another_folder_name_or_order_gives_the_same_model(pool, tmp_path, capsys):
    order = ["S3-AF", "S1-AF", "S2-AF"]
    run(
        capsys,
        "identify",
        *(pool / n for n in order),
        "--vehicle",
        pool / "vehicle-AF.yaml",
        "-o",
        tmp_path / "m",
    )
    a, b = seatrial.load(pool / "model.yaml"), seatrial.load(tmp_path / "m")
    assert a.values == pytest.approx(b.values, rel=1e-9)


def test_a_positive_drag_is_a_doubt_not_an_error(pool, tmp_path, capsys):
    """The paper-like noise makes X_u positive for some seeds: identify says so and writes the model."""
    model = seatrial.load(pool / "model.yaml")
    assert any(model.values[n] > 0 for n in ("X_u", "Y_v", "N_r")) == bool(model.warnings)


@pytest.mark.parametrize(
    "arguments", [[], ["sail"], ["identify"], ["identify", "x", "--method", "magic"]]
)
def test_wrong_arguments_get_one_line_and_exit_with_2(arguments, capsys):
    with pytest.raises(SystemExit) as left:
        main(arguments)
    assert left.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("seatrial")
    assert said.endswith("--help\n")
    assert said.count("\n") == 1


def test_the_installed_command_runs_and_is_quick_to_start():
    assert printed(PROGRAM, "--version").startswith("seatrial 0.")
    cut = piped(f"{PROGRAM} inspect {' '.join(SHIP)} | head -1", shell=True, check=True)
    assert cut.stderr == ""


def test_progress_is_silent_where_there_is_no_terminal(pool, tmp_path):
    command = [PROGRAM, "identify", pool / "S7-AF"]
    command += ["--vehicle", pool / "vehicle-AF.yaml", "-o", tmp_path / "m.yaml"]
    command += ["--start", "100", "--end", "200"]
    shown = piped(command, check=True)
    assert shown.stderr == ""


def test_validate_says_what_the_model_was_identified_from(pool, capsys):
    model = pool / "model.yaml"
    out = done(capsys, "validate", model, pool / "S1-AF", pool / "S7-AF")
    assert "identified from S1-AF: no test of it" in out


def test_an_interrupt_while_a_command_is_imported_is_quiet(monkeypatch, capsys):
    from seatrial.commands import cli

    def interrupted(_: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("seatrial.commands.import_module", interrupted)
    assert cli.main(["inspect", "none"]) == 130
    assert capsys.readouterr().err == ""
