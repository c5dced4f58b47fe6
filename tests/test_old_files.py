# SPDX-License-Identifier: MIT
"""Model and scores files of the versions before findings: read, mean the same, written as new ones."""

import json
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

from seatrial.boat.findings import Finding, FindingKind, finding_of, of_kinds
from seatrial.boat.model_file import MODEL_FORMAT, load, save
from seatrial.boat.older_files.notes import findings_of
from seatrial.evaluation.scores import load_scores
from seatrial.identification.diagnostics.boat_changes import DISAGREEMENTS
from seatrial.identification.diagnostics.unmodelled_effects import EFFECTS_FOUND
from seatrial.identification.selection.actuator_stages import CHAIN_FINDINGS, STAGES_SELECTED
from seatrial.identification.selection.terms.select_terms import CHANGES, DISTURBANCES
from seatrial.util.errors import SeatrialError
from seatrial.util.files import read_yaml

MODELS = Path(__file__).parent / "models"
OLD = {  # as identified by that version, and their findings
    "cse1-model-2.yaml": [
        finding_of(FindingKind.GROUP_STAGES_SELECTED, "F_u", "F_v", "F_b", stage="lag"),
        finding_of(FindingKind.AT_BOUND, "lag.lag_F_v", bound=0.002),
        finding_of(FindingKind.MODEL_MISMATCH, horizon=0.8),
    ],
    "cse1-pair-model-2.yaml": [
        finding_of(
            FindingKind.SCALE_POWER_HELD, "scale_power.propellers", "propeller_speed", power=2.0
        ),
        finding_of(FindingKind.MODEL_MISMATCH, horizon=0.8),
    ],
    "mallard-af-model-2.yaml": [
        finding_of(FindingKind.DEAD_ZONE_NOT_IDENTIFIABLE, "F_1", "F_2", "F_3", "F_4")
    ],
}
IF = ": if that may be, identify with --effect {}, before further terms are sought"
EXPLAINED = "more than half of the unmodelled force would be explained by "
HAND = (
    "poses are 1.8 to 3.2 times as far from what is predicted as elsewhere in S1 first half from 12 s to "
    "18.4 s, 40 s to 44 s; S2 from 0 s to 9.9 s: was the boat held, carried or bumped there, or did a thruster "
    "stop? If so, leave that out with --without 'S1 first half'=12-18.4 --without 'S1 first half'=40-44 --without "
    "S2=0-9.9"
)


def interval(name: str, start: float, end: float) -> Finding:
    return finding_of(FindingKind.DISTURBED_INTERVAL, name, start=start, end=end, ratio=3.2)


def scaled(kind: FindingKind, *subject: str, **values: float | str) -> Finding:
    return finding_of(kind, *subject, **{"dead_zone": "modelled", **values})


HANDS = [interval("S1 first half", 12.0, 18.4), interval("S1 first half", 40.0, 44.0), interval("S2", 0.0, 9.9)]  # fmt: skip
CLOCK = "the recordings do not agree: commands act 0.05 s later in odd than in even: were clocks set anew in between? Put the stamps right. To check, identify them separately and run compare"
SENTENCES = {
    "lag: 0.002 is the bound of its range": [finding_of(FindingKind.AT_BOUND, "lag", bound=0.002)],
    "lag.fast: 1: -1.5e-07 is the bound of its range": [
        finding_of(FindingKind.AT_BOUND, "lag.fast: 1", bound=-1.5e-7)
    ],
    "standard errors of the lever arm: 1.0e-02 m ahead, 2.5e-03 m aside": [
        finding_of(FindingKind.LEVER_ARM_ERRORS, ahead=0.01, aside=0.0025)
    ],
    "power of the thrust curve: estimated, as the data ask for it": [
        finding_of(FindingKind.CURVE_STAGE_SELECTED, stage="power")
    ],
    "reverse over forward of the thrust curve: estimated, as the data ask for it": [
        finding_of(FindingKind.CURVE_STAGE_SELECTED, stage="reverse_ratio")
    ],
    "a reverse over forward for each of t1+t2, t3: estimated, as the data ask for it": [
        finding_of(FindingKind.GROUP_STAGES_SELECTED, "t1+t2", "t3", stage="reverse_ratio")
    ],
    "dead zone: not sought, as the commands are F_u, F_v, F_r, not thrusters'; if thrusters have one, force and drag coefficients come out wrong: add thrusters: and allocation: to the vehicle file": [
        finding_of(FindingKind.DEAD_ZONE_NOT_SOUGHT, "F_u", "F_v", "F_r")
    ],
    "dead zone: one edge for both sides, as left, right hardly push astern": [
        finding_of(FindingKind.DEAD_ZONE_ONE_EDGE, "left", "right", side="astern")
    ],
    "dead zone of F_b: not identifiable, as under these commands of bow it always takes the same share of each force; the force coefficients include it": [
        finding_of(FindingKind.DEAD_ZONE_NOT_IDENTIFIABLE, "bow")
    ],
    "scale_power.pods: taken as 2, as propeller speed hardly changes in the recordings where there is a command": [
        finding_of(FindingKind.SCALE_POWER_HELD, "scale_power.pods", "propeller speed", power=2.0)
    ],
    "standard errors: from blocks of 5.0 s, as the recordings are short": [
        finding_of(FindingKind.SHORT_BLOCKS, length=5.0)
    ],
    "the structure is not quite right: poses count as if noisier, by 20 % of the way gone in a second, which predicts one second ahead at least as well as the likelihood's choice; 'seatrial select' tries further terms": [
        finding_of(FindingKind.MODEL_MISMATCH, horizon=0.2)
    ],
    "3.0 % of the poses are outliers to the model and count less": [
        finding_of(FindingKind.OUTLIERS, share=0.03)
    ],
    "no coefficient differs clearly from zero: do commands and poses belong together? Check with inspect": [
        finding_of(FindingKind.NO_SIGNIFICANT_COEFFICIENT)
    ],
    "no second of these recordings can be predicted: the model runs away from the velocities that occur, or there are no poses in a row; look at them with inspect": [
        finding_of(FindingKind.NOT_PREDICTABLE)
    ],
    "in surge and yaw, one second ahead hardly better than constant or zero velocity: do commands and poses belong together? Check with inspect, and the vehicle file's signs": [
        finding_of(FindingKind.NO_BETTER_THAN_CONSTANT, "surge", "yaw")
    ],
    f"{EXPLAINED}poses of a point about 0.36 m off the origin, a lever arm{IF.format('lever')}": [
        finding_of(FindingKind.UNMODELLED_LEVER_ARM, size=0.36)
    ],
    f"{EXPLAINED}a current of up to 0.1 m/s{IF.format('current')}": [
        finding_of(FindingKind.UNMODELLED_CURRENT, size=0.1)
    ],
    f"{EXPLAINED}a steady push, as of thrusters that are not quite at rest{IF.format('trim')}": [
        finding_of(FindingKind.UNMODELLED_TRIM)
    ],
    f"{EXPLAINED}wind{IF.format('wind')}": [finding_of(FindingKind.UNMODELLED_WIND)],
    f"{EXPLAINED}thrusters that do not thrust alike (is a propeller fouled or damaged?): if that may be, add {{gains: {{a: 0.8, b: 1.2}}}} and {{gains: {{c: 1.1, d: 0.9}}}} to the vehicle file's chain and identify again, before further terms are sought": [
        finding_of(FindingKind.UNEQUAL_THRUSTER_GAINS, "a", "b", gains=(0.8, 1.2), weak="one"),
        finding_of(FindingKind.UNEQUAL_THRUSTER_GAINS, "c", "d", gains=(1.1, 0.9), weak="one"),
    ],
    "poses fit far better with a heading that is off by 180 degrees: if that may be, write offset: -0.07 at pose: psi in the vehicle file and identify again, before further terms are sought": [
        finding_of(FindingKind.HEADING_OFFSET, size=np.pi, psi_offset=-0.07)
    ],
    "the recordings do not agree: thrust in surge 12 %, in yaw 8 % less in S5 than in S1; in sway 9 % less in S4 than in S1: is that the dead zone, which was not sought (small commands thrust less for it)? Else, did the battery fall, or trim change? To check, identify them separately and run compare": [
        finding_of(FindingKind.HOMOGENEITY, *names, change=change, quantity="thrust", dead_zone="not modelled")
        for names, change in (
            (("surge", "S5", "S1"), 0.12),
            (("yaw", "S5", "S1"), 0.08),
            (("sway", "S4", "S1"), 0.09),
        )
    ],
    "the recordings do not agree: thrust and drag in surge 23 % less in loaded than in light: did the payload change? To check, identify them separately and run compare": [
        scaled(FindingKind.HOMOGENEITY, "surge", "loaded", "light", change=0.23, quantity="thrust and drag")
    ],
    CLOCK: [finding_of(FindingKind.CLOCK_HOMOGENEITY, "odd", "even", delay=0.05)],
    "the boat changes in the course of a recording: drag in sway 12 % less at the beginning of a recording like S3 than at its end: did the water change, or something trailing in it, or is a drag term missing? Coefficients hold for its middle; for other parts, cut the recording with --without and run compare": [
        scaled(
            FindingKind.PARAMETER_DRIFT, "sway", "S3", change=0.12, quantity="drag", lower="beginning", higher="end",
            of="all recordings",
        )
    ],
    HAND: HANDS,
    f"{HAND}. Standard errors are then 0.52 times these, and X_u, which changes most, is -0.21 ± 0.012": [
        *HANDS,
        finding_of(FindingKind.DISTURBANCE_INFLUENCE, "X_u", ratio=0.52, value=-0.21, error=0.012),
    ],
    "Prior: an older model, widened by 20 % of every parameter.": [
        finding_of(FindingKind.PRIOR_USED, spread=0.2)
    ],
    "Prior and recording contradict each other in X_F (0.14 ± 0.0031 to 0.12 ± 0.001), thrust (0.52 in surge, 0.48 in yaw of the prior's): more changed than that, or the recording is not good; take a larger --prior-spread, or drive as for a new model.": [
        finding_of(FindingKind.PRIOR_CONFLICT, "X_F", prior=0.14, prior_error=0.0031, found=0.12, found_error=0.001),
        finding_of(FindingKind.PRIOR_FACTOR, "surge", quantity="thrust", factor=0.52),
        finding_of(FindingKind.PRIOR_FACTOR, "yaw", quantity="thrust", factor=0.48),
    ],
    "The recording says little of Y_v, edge_reverse: mostly the prior's values.": [
        finding_of(FindingKind.PRIOR_DOMINATES, "Y_v", "edge_reverse")
    ],
    "The prior was identified from S7, too: what is in there counts twice; give recordings that it has not seen.": [
        finding_of(FindingKind.PRIOR_COUNTED_TWICE, "S7")
    ],
    "no starts from a filter, no residuals: it runs away": [
        finding_of(FindingKind.NO_FILTER, reason="it runs away")
    ],
    "the error is in surge 1.8 times (5 s ahead), in yaw 1.4 times (0.5 s ahead) what the model foresees of itself: though it was identified from this: its structure misses something": [
        finding_of(FindingKind.EXCEEDS_EXPECTED_ERROR, axis, ratio=ratio, horizon=horizon, cause="model mismatch")
        for axis, ratio, horizon in (("surge", 1.8, 5.0), ("yaw", 1.4, 0.5))
    ],
    "poses are 1 s apart: the stencil's velocities, which errors are taken against, miss motion within four of them; the floor includes as much of it as the model shows": [
        finding_of(FindingKind.SLOW_POSES, period=1.0)
    ],
    "a sentence that no version wrote": [
        finding_of(FindingKind.OTHER, text="a sentence that no version wrote")
    ],
}  # fmt: skip
RULES = [  # how code of that time understood a sentence, and which kinds it asks for now
    (lambda n: n.endswith("is the bound of its range"), (FindingKind.AT_BOUND,)),
    (lambda n: n.startswith("standard errors of the lever arm"), (FindingKind.LEVER_ARM_ERRORS,)),
    (lambda n: n.endswith("estimated, as the data ask for it"), STAGES_SELECTED),
    (lambda n: n.startswith(("dead zone", "scale_power")), CHAIN_FINDINGS),
    (lambda n: "one edge for both sides" in n, (FindingKind.DEAD_ZONE_ONE_EDGE,)),
    (lambda n: n.startswith(EXPLAINED.strip()), EFFECTS_FOUND),
    (lambda n: "as far from what is predicted as elsewhere" in n, DISTURBANCES),
    (lambda n: n.startswith("the recordings do not agree"), DISAGREEMENTS),
    (
        lambda n: n.startswith(("the recordings do not agree", "the boat changes in the course of a recording")),
        CHANGES,
    ),
]  # fmt: skip


@pytest.mark.parametrize("name", OLD)
def test_a_model_of_then_is_read_and_written_as_one_of_now(name, tmp_path):
    model = load(MODELS / name)
    assert model.estimator.findings == OLD[name]
    save(model, tmp_path / "new.yaml")
    written, old = (read_yaml(p) for p in (tmp_path / "new.yaml", MODELS / name))
    assert written["seatrial"] == MODEL_FORMAT
    assert "notes" not in written["estimator"]
    again = load(tmp_path / "new.yaml")
    assert again.estimator == model.estimator
    for key in ("coefficients", "constants", "covariance", "noise", "recordings", "vehicle"):
        assert written[key] == old[key], key


def test_what_it_knows_of_bounds_and_errors_is_what_it_knew(tmp_path):
    assert load(MODELS / "cse1-model-2.yaml").at_bounds == {"lag.lag_F_v"}
    assert load(MODELS / "cse1-pair-model-2.yaml").at_bounds == frozenset()
    content = yaml.safe_load((MODELS / "mallard-af-model-2.yaml").read_text())
    content["estimator"]["notes"] = list(SENTENCES)
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(content))
    model = load(path)
    assert model.lever_errors == (0.01, 0.0025)
    assert model.estimator.findings == [f for found in SENTENCES.values() for f in found]


@pytest.mark.parametrize("sentence", SENTENCES)
def test_a_sentence_is_the_findings_that_it_stands_for(sentence):
    found = findings_of([sentence])
    assert [(f.kind, f.subject) for f in found] == [
        (f.kind, f.subject) for f in SENTENCES[sentence]
    ]
    for one, expected in zip(found, SENTENCES[sentence], strict=True):
        for name, value in expected.values.items():
            told = isinstance(value, str)
            assert one.values[name] == (value if told else pytest.approx(value, rel=1e-12)), name


@pytest.mark.parametrize("sentence", SENTENCES)
def test_code_asks_for_a_kind_where_it_asked_for_a_wording(sentence):
    found = findings_of([sentence])
    for wording, kinds in RULES:
        assert bool(of_kinds(found, *kinds)) == wording(sentence)


def test_every_kind_that_was_a_sentence_is_read():
    """All but those that did not begin with words of their own."""
    read = {finding.kind for found in SENTENCES.values() for finding in found}
    newer = {
        FindingKind.DELAY, FindingKind.DELAY_DIFFERENCE, FindingKind.UNMODELLED_DELAY,
        FindingKind.MISSING_TERM, FindingKind.THROUGH_WATER, FindingKind.ADAPTED,
        FindingKind.THRUSTER_LAYOUT_SELECTED, FindingKind.THRUSTER_LAYOUT_CONTRADICTED,
        FindingKind.SMOOTH_POSITION, FindingKind.UNEVEN_CURRENT, FindingKind.COMPASS_DEVIATION, FindingKind.HEADING_JUMP, FindingKind.HEADING_DRIFT, FindingKind.SMOOTH_HEADING, FindingKind.COMMANDS_SAMPLED, FindingKind.FORCE_ADDED,
        FindingKind.COMMANDS_LOOK_SAMPLED, FindingKind.LATE_COMMANDS, FindingKind.CLOCK_DRIFT,
        FindingKind.CONTRADICTED, FindingKind.SLEW_RATE_SELECTED, FindingKind.BEYOND_RANGE,
    }  # fmt: skip
    assert set(FindingKind) - read == {FindingKind.HORIZON_NOT_PREDICTED, *newer}


def test_scores_of_then_are_read():
    scores = load_scores(MODELS / "cse1-scores-3.json")
    cause = {"horizon": 0.1, "cause": "pose noise"}
    kind = FindingKind.EXCEEDS_EXPECTED_ERROR
    assert scores.recordings[0].findings == [
        finding_of(kind, "sway", ratio=1.4, **cause),
        finding_of(kind, "yaw", ratio=1.5, **cause),
    ]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda e: e.update(notes="lag"), "estimator: notes: expected a list of texts"),
        (lambda e: e.update(notes=["lag", 1]), "estimator: notes: expected a list of texts"),
        (lambda e: e.update(findings=[]), "estimator: unknown key 'findings'"),
        (lambda e: e.update(remarks=[]), "unknown key 'remarks' in estimator"),
    ],
)
def test_a_file_of_then_that_is_not_right_is_one_clear_line(tmp_path, change, words):
    content = yaml.safe_load((MODELS / "mallard-af-model-2.yaml").read_text())
    change(content["estimator"])
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(SeatrialError, match=words):
        load(path)


def test_a_file_of_now_has_no_sentences(tmp_path):
    path = tmp_path / "model.yaml"
    save(load(MODELS / "mallard-af-model-2.yaml"), path)
    content = yaml.safe_load(path.read_text())
    content["estimator"]["notes"] = []
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(SeatrialError, match="unknown key 'notes' in estimator"):
        load(path)


def test_sentences_that_are_made_to_be_slow_are_not():
    """A file may hold anything: what is looked at is limited, in length and in number."""
    heads = [s[:60] for s in SENTENCES]
    notes = [(head + " 1, 1 s to 1 % (" * 1000)[:2999] for head in heads] + ["1" * 2999] * 1000
    began = time.process_time()
    found = findings_of([*notes, "x" * 100_000])
    assert time.process_time() - began < 20.0  # [s] CPU
    assert found[-1].kind is FindingKind.OTHER
    assert len(found[-1].values["text"]) == 3000
    assert json.dumps([dict(f.values) for f in found])
