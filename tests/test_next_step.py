# SPDX-License-Identifier: MIT
"""The next step after a command: a line that can be run, from the finding that matters most."""

import argparse
import shlex
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from cli_tools import done, run
from conftest import make_model
from survey_boat import TRUTH, boat

import seatrial
from seatrial.boat.finding_kinds import ASK_FOR_ACTION
from seatrial.boat.findings import (
    FindingKind,
    advice_of,
    finding_of,
    finding_text,
    most_important,
    sentence_of,
)
from seatrial.boat.schema import EstimatorEntry
from seatrial.commands import make_parser
from seatrial.commands.shared import add_recordings, recordings_again
from seatrial.evaluation.scores import AxisScore, RecordingScore, Scores
from seatrial.identification.console import MOST_FINDINGS, summary
from seatrial.inspection.coverage import AxisCoverage, InputUse
from seatrial.inspection.overview import Inspection, RecordingView
from seatrial.util.frames import AXES
from seatrial.workflow.next_step import after_identify, after_inspect, after_select, after_validate

LOGS, VEHICLE = ["my log.bag", "b.bag"], "v.yaml"
CURRENT = finding_of(FindingKind.UNMODELLED_CURRENT, size=0.08)
MISSING = finding_of(FindingKind.MISSING_TERM, "yaw", "N_uv * u * v", errors=9.0, improvement=0.2)
AT_BOUND = finding_of(FindingKind.AT_BOUND, "lag", bound=0.002)
DISTURBED = finding_of(FindingKind.DISTURBED_INTERVAL, "my log", start=3.5, end=8.0, ratio=4.0)
MISMATCH = finding_of(FindingKind.MODEL_MISMATCH, horizon=1.0)
OUTLIERS = finding_of(FindingKind.OUTLIERS, share=0.05)


def model_with(*findings, warnings=(), spread=0.001):
    """A well-known model with findings."""
    model = make_model(boat(), TRUTH)
    theta = np.concatenate([model.coefficients, model.constants])
    return replace(
        model,
        covariance=np.diag((spread * np.where(theta == 0.0, 1.0, theta)) ** 2),
        estimator=EstimatorEntry("output-error", {}, findings=list(findings)),
        warnings=tuple(warnings),
    )


def parsed(step):
    """The command of a step, as the program reads it."""
    words = shlex.split(step.do)
    assert words[0] == "seatrial"
    return words[1], make_parser().parse_args(words[1:])


def test_an_unmodelled_effect_is_estimated_with_the_options_there_were():
    options = ["--effect", "lever", "--without", "b=3-9"]
    step = after_identify(model_with(AT_BOUND, MISSING, CURRENT), LOGS, VEHICLE, "m.yaml", options)
    name, args = parsed(step)
    assert name == "identify" and [str(p) for p in args.recordings] == LOGS
    assert args.effect == ["lever", "current"] and args.without == ["b=3-9"]
    assert (str(args.vehicle), str(args.out)) == (VEHICLE, "m.yaml")
    assert "a current of up to 0.08 m/s" in step.why and "identify with" not in step.why
    assert step.text.startswith("next: seatrial identify 'my log.bag'") and "\n" not in step.text


@pytest.mark.parametrize(
    ("finding", "name", "attribute", "value"),
    [
        (MISSING, "identify", "structure", "auto"),
        (MISMATCH, "select", "out", "v-chosen.yaml"),
        (OUTLIERS, "inspect", "vehicle", VEHICLE),
        (DISTURBED, "identify", "without", ["my log=3.5-8"]),
    ],
)
def test_a_finding_has_its_command(finding, name, attribute, value):
    got, args = parsed(after_identify(model_with(finding), LOGS, VEHICLE, "m.yaml"))
    found = getattr(args, attribute)
    assert got == name and (found if isinstance(found, list) else str(found)) == value


def test_what_no_command_mends_is_advice():
    offset = finding_of(FindingKind.HEADING_OFFSET, size=0.3, psi_offset=0.3)
    step = after_identify(model_with(offset), LOGS, VEHICLE)
    assert step.do == advice_of(offset) and step.why == sentence_of(offset)


def test_doubts_come_first():
    step = after_identify(
        model_with(CURRENT, warnings=["lake: 9 % of its poses are left out"]), LOGS, VEHICLE
    )
    assert parsed(step)[0] == "inspect" and step.why == "lake: 9 % of its poses are left out"


@pytest.mark.parametrize("model", [model_with(OUTLIERS), model_with(warnings=["rounded to 0.1 m"])])
def test_what_inspect_can_not_mend_does_not_send_back_to_it(model):
    def step(found):
        return after_identify(model, LOGS, VEHICLE, "m.yaml", look=lambda: found)

    assert parsed(step(inspected()))[0] == "validate"
    assert parsed(step(inspected(usable=0.7)))[0] == "validate"
    assert parsed(step(inspected(findings=["F_u is reversed: sign: -1"])))[0] == "inspect"
    assert parsed(step(inspected(undriven=["my log=-39"])))[0] == "inspect"


def test_select_is_not_asked_again_for_terms_that_it_chose():
    chosen = after_identify(model_with(MISMATCH), LOGS, VEHICLE, "m.yaml", automatic=True)
    assert parsed(chosen)[0] == "validate"
    assert parsed(after_select(LOGS, "v2.yaml", changed=False))[0] == "validate"
    assert parsed(after_select(LOGS, "v2.yaml"))[0] == "identify"


def test_a_good_model_is_tested_next_and_a_loose_one_says_so():
    name, args = parsed(after_identify(model_with(AT_BOUND), LOGS, VEHICLE, "m.yaml"))
    assert name == "validate" and str(args.model) == "m.yaml"
    loose = after_identify(model_with(spread=0.4), LOGS, VEHICLE, "m.yaml")
    assert parsed(loose)[0] == "validate" and "standard errors are large: " in loose.why


def test_every_kind_has_a_place_and_sentence_and_advice_are_its_text():
    assert len(set(ASK_FOR_ACTION)) == len(ASK_FOR_ACTION)
    assert [f.kind for f in most_important([AT_BOUND, DISTURBED, CURRENT])] == [
        CURRENT.kind, DISTURBED.kind, AT_BOUND.kind,
    ]  # fmt: skip
    assert finding_text(CURRENT) == f"{sentence_of(CURRENT)}. {advice_of(CURRENT)}"


def test_a_brief_summary_has_what_matters_most_and_counts_the_rest():
    model = model_with(AT_BOUND, DISTURBED, MISSING, CURRENT, warnings=["poses are rounded"])
    said, whole = summary(model, brief=True), summary(model)
    shown = [line for line in said.splitlines() if line.startswith("  - ")]
    assert len(shown) == MOST_FINDINGS and "(2 further remarks: -v shows them)" in said
    assert "doubt: poses are rounded" in shown[0] and "a current of up to" in shown[1]
    assert all(finding_text(f) in whole for f in (AT_BOUND, DISTURBED, MISSING, CURRENT))
    assert "What matters most" not in summary(model_with(), brief=True)
    calm = summary(model_with(AT_BOUND), brief=True)
    assert "No finding asks for an action (1 further remark: -v shows it)." in calm


def test_a_brief_summary_has_the_delay_that_was_asked_for():
    """As it has lever arm and current: it is a result, no remark."""
    kind = FindingKind.DELAY_DIFFERENCE
    late = finding_of(kind, "position", "heading", delay=0.3, error=0.01)
    said = summary(model_with(late), brief=True)
    assert "the position is 0.300 ± 0.01 s older than the heading" in said and "remark" not in said


def scores(ratio, *, seen=False, findings=()):
    """Scores of one recording."""
    one = AxisScore(ratio, 1.0, ratio, 0.01, 0.1, 0.01, ratio, 0.0, 3.0, None, None, None, None)
    row = RecordingScore(
        "S7", 100.0, 50, 1.0, seen, None, dict.fromkeys("uvr", one), findings=list(findings)
    )
    return Scores("scores 6", "boat", "output-error", 1.0, [row])


@pytest.mark.parametrize(
    ("found", "name", "why"),
    [
        (scores(0.3), "report", ""),
        (scores(0.3, seen=True), "validate", "identified from these"),
        (scores(0.95), "report", "surge, sway and yaw hardly better than a constant velocity"),
        (
            scores(0.3, findings=[
                finding_of(FindingKind.EXCEEDS_EXPECTED_ERROR, "yaw", ratio=3.0, horizon=1.0, cause="change")
            ]),
            "report", "3.0 times the expected error",
        ),
    ],
)  # fmt: skip
def test_scores_ask_for_a_test_a_look_or_nothing(found, name, why):
    step = after_validate("m.yaml", msgspec.structs.replace(found), LOGS)
    assert parsed(step)[0] == name and why in step.why


def test_what_moves_without_commands_is_left_out_of_the_test():
    step = after_validate("m.yaml", scores(0.3), LOGS, undriven=["my log=70-120"])
    name, args = parsed(step)
    assert name == "validate" and args.without == ["my log=70-120"] and len(args.recordings) == 2
    assert parsed(after_validate("m.yaml", scores(0.3), LOGS))[0] == "report"


def inspected(*, usable=1.0, sway=0.3, findings=(), inputs=(), undriven=()):
    """An inspection of one recording by the paper's boat."""
    axes = [
        AxisCoverage(a, r, 1.0, 0.3, True, 1.0, 1.0, 1.0, 1.0, 1.0)
        for a, r in zip(AXES, (0.3, sway, 0.3), strict=True)
    ]
    view = RecordingView(
        "S1", 0.0, 60.0, 900, 15.0, 0.0, usable, None, (), (), tuple(axes), inputs, ()
    )
    signs = SimpleNamespace(
        findings=[SimpleNamespace(text=text, leave_out=None) for text in findings]
    )
    return Inspection(seatrial.load_vehicle("mallard-mp"), (view,), signs, tuple(undriven))


@pytest.mark.parametrize(
    ("found", "do"),
    [
        (inspected(), "seatrial identify 'my log.bag' b.bag --vehicle v.yaml -o model.yaml"),
        (inspected(findings=["F_u is reversed: sign: -1"]), "correct v.yaml"),
        (inspected(inputs=(InputUse("F_u", 1100.0, 1900.0, 1.0, 800, 0.0, False),)), "correct v.yaml"),
        (inspected(usable=0.7), "seatrial identify 'my log.bag' b.bag --vehicle v.yaml -o model.yaml"),
        (
            inspected(undriven=["my log=-39"]),
            "seatrial identify 'my log.bag' b.bag --without 'my log=-39' --vehicle v.yaml -o model.yaml",
        ),
        (inspected(sway=0.0), "record more with pulses of sway"),
    ],
)  # fmt: skip
def test_after_inspect_the_file_is_corrected_or_more_is_recorded_or_a_model_identified(found, do):
    assert after_inspect(found, LOGS, VEHICLE).do == do


READ = {"start": 1.25, "end": 1234.56789012, "without": ["b=3-9", "b=20-"], "salvage": True}
READ_AS = ["--start", "1.25", "--end", "1234.56789012", "--without", "b=3-9", "--without", "b=20-", "--salvage"]  # fmt: skip
LINES = {
    "inspect, then identify": lambda a: after_inspect(inspected(), a, VEHICLE),
    **{
        f"identify, then {finding.kind.name}": partial(after_identify, model_with(finding), vehicle=VEHICLE)
        for finding in (CURRENT, MISSING, DISTURBED, MISMATCH, OUTLIERS)
    },
    "doubts": partial(after_identify, model_with(warnings=["9 % of the poses are left out"]), vehicle=VEHICLE),
    "select, then identify": lambda a: after_select(a, VEHICLE),
    "validate, then report": lambda a: after_validate("m.yaml", scores(0.3), a, ["--vehicle", VEHICLE]),
}  # fmt: skip


@pytest.mark.parametrize("line", LINES)
def test_a_further_command_reads_the_same_recordings_in_the_same_way(line):
    """Every option of `add_recordings` but --vehicle, which has its own place, is in `READ`, and survives."""
    probe = argparse.ArgumentParser()
    add_recordings(probe)
    assert set(vars(probe.parse_args(LOGS))) == {"recordings", "vehicle", *READ}
    args = probe.parse_args([*LOGS, *READ_AS])
    assert {name: getattr(args, name) for name in READ} == READ
    _, further = parsed(LINES[line](recordings_again(args)))
    assert [str(path) for path in further.recordings] == LOGS and str(further.vehicle) == VEHICLE
    without = [*READ["without"], "my log=3.5-8"] if DISTURBED.kind.name in line else READ["without"]
    assert {name: getattr(further, name) for name in READ} == {**READ, "without": without}


def test_commands_hand_on_how_they_read(pool, af, tmp_path, capsys, monkeypatch):
    recording, vehicle, model = pool / "S7-AF", str(pool / "vehicle-AF.yaml"), pool / "model.yaml"
    cut = [recording, "--start", "2.5", "--end", "61.125", "--without", "S7-AF=8-9", "--salvage"]
    chosen = "seatrial.identification.selection.terms."
    fewer = SimpleNamespace(vehicle=af.with_terms(af.structure.terms[:-1]))
    monkeypatch.setattr(f"{chosen}select", lambda *_, **__: fewer)
    monkeypatch.setattr(f"{chosen}selection_text", lambda _: "no table")
    monkeypatch.setattr(f"{chosen}selection_json", lambda _: {})
    doubtful = model_with(CURRENT)
    method = "seatrial.identification.methods.identify_with_fit"
    monkeypatch.setattr(method, lambda *_, **__: (doubtful, None))

    def following(*arguments):
        out = done(capsys, *arguments)
        words = shlex.split(out.partition("\nnext: ")[2], comments=True)
        return make_parser().parse_args(words[1:])

    for arguments in (
        ["inspect", *cut, "--vehicle", vehicle],
        ["identify", *cut, "--vehicle", vehicle, "-o", tmp_path / "m.yaml"],
        ["select", *cut, "--vehicle", vehicle, "-o", tmp_path / "chosen.yaml"],
        ["validate", model, *cut, "--vehicle", vehicle, "--horizon", "1.5"],
    ):
        args = following(*arguments)
        assert args.recordings == [recording] and args.salvage
        assert (args.start, args.end, args.without) == (2.5, 61.125, ["S7-AF=8-9"])
    assert (args.vehicle, args.horizon) == (vehicle, 1.5)
    assert following("inspect", recording, "--salvage").salvage
    assert following("init", recording, "--salvage", "-o", tmp_path / "v.yaml").salvage


def test_a_further_identification_keeps_the_options_of_the_first(
    pool, tmp_path, capsys, monkeypatch
):
    method = "seatrial.identification.methods.identify_with_fit"
    monkeypatch.setattr(method, lambda *_, **__: (model_with(CURRENT), None))
    options = ["--prior", pool / "model.yaml", "--prior-spread", "0.123", "--role", "yaw=S7-AF"]
    options += ["--method", "equation-error", "--literal", "--effect", "lever"]
    vehicle, out = ["--vehicle", pool / "vehicle-AF.yaml"], ["-o", tmp_path / "m.yaml"]
    code, said, _ = run(capsys, "identify", pool / "S7-AF", *vehicle, *out, *options)
    words = shlex.split(said.partition("\nnext: ")[2], comments=True)
    args = make_parser().parse_args(words[1:])
    assert code == 0 and args.effect == ["lever", "current"] and args.role == ["yaw=S7-AF"]
    assert (args.prior, args.prior_spread) == (pool / "model.yaml", 0.123)
    assert (args.method, args.literal) == ("equation-error", True)
