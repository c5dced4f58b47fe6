# SPDX-License-Identifier: MIT
"""An older model as prior: how wide it is made, what a short recording makes of it."""

from dataclasses import replace

import numpy as np
import pytest
from cli_tools import done, refused
from conftest import TABLE_II, make_model

import seatrial
from seatrial.boat.findings import FindingKind, finding_of, finding_text
from seatrial.boat.schema import EnvelopeEntry, EstimatorEntry, RecordingEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.commands.cli import main
from seatrial.identification.estimator import OutputErrorSettings, fit, output_error
from seatrial.identification.methods import identify
from seatrial.identification.prior import (
    check_prior,
    widened,
)
from seatrial.identification.provenance import recording_entry
from seatrial.io.trial_files import write_trial
from seatrial.simulation.plan import DisturbanceForce, load_plan, with_seed
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import IdentificationError
from tests.boats.hulls import MIDDLE, driven
from tests.boats.plans import planned

CONFLICTS = (FindingKind.PRIOR_CONFLICT, FindingKind.PRIOR_FACTOR)
SPEEDS = {"u": (-0.2, 0.25), "v": (-0.3, 0.4), "r": (-1.0, 0.8)}
FORCES = {"F_u": (-1.0, 0.9), "F_v": (-1.0, 1.0), "F_r": (-0.5, 0.5)}
MORE = 1.2  # times the mass


def known(model, relative=0.01):
    """The model as if it had been identified so well."""
    both = np.concatenate([model.coefficients, model.constants])
    covariance = np.diag(np.square(relative * np.maximum(np.abs(both), 0.01)))
    return replace(
        model, covariance=covariance, envelope=EnvelopeEntry(SPEEDS, FORCES),
        recordings=(RecordingEntry("before", 600.0),), estimator=EstimatorEntry("output-error"),
    )  # fmt: skip


def minute(plan, vehicle):
    """S7 of a plan, a minute of it."""
    return next(iter(simulate(planned(plan, "S7", seconds=60.0), vehicle)))


@pytest.fixture(scope="module")
def before(mp):
    return known(plant_model(load_plan("hard"), mp))


@pytest.fixture(scope="module")
def after(mp):
    """A minute of the boat with its payload off centre, pushed about by what no model knows."""
    plan = load_plan("hard")
    values = {name: value / MORE for name, value in plan.plant.coefficients.items()}
    values["N_ud"] += 0.1
    plan = planned(plan, coefficients=values, plant={"unmodelled": DisturbanceForce(0.04, 2.0)})
    return values, [minute(with_seed(plan, seed), mp) for seed in (1, 2, 3)]


@pytest.fixture
def recording(after):
    """The first of those minutes."""
    return after[1][0].recording


def test_a_prior_is_widened_by_a_share_of_every_parameter(before):
    wide = widened(before, 0.3)
    own, new = before.standard_errors, wide.standard_errors
    for name in ("X_u", "X_uu", "Y_vv", "N_r", "N_F", "X_F", "lag"):
        value = before.values.get(name, 0.08)
        assert new[name] == pytest.approx(np.hypot(own[name], 0.3 * value)), name
    assert new["edge_forward"] == pytest.approx(np.hypot(0.0008, 0.3 * 0.08))
    assert wide.values == before.values
    added = wide.covariance - before.covariance
    assert np.linalg.eigvalsh(added).min() > 0
    at = {name: i for i, name in enumerate(wide.parameters)}
    assert added[at["X_u"], at["X_F"]] == pytest.approx(0.5 * 0.3**2 * -0.2 * 0.14)
    assert added[at["N_r"], at["N_F"]] == pytest.approx(0.5 * 0.3**2 * -0.48 * 1.3)
    for one, other in (("X_u", "Y_v"), ("N_ud", "N_F"), ("X_u", "lag")):
        assert added[at[one], at[other]] == 0.0


def test_a_coefficient_near_nothing_may_become_a_term_of_note(before):
    """N_ud u_dot: a fifth of 1.3 * 0.5 rad/s^2, at 0.14 * 1 m/s^2, times the spread."""
    expected = 0.2 * 0.2 * (1.3 * 0.5) / (0.14 * 1.0)
    got = widened(before, 0.2).standard_errors["N_ud"]
    assert got == pytest.approx(np.hypot(expected, before.standard_errors["N_ud"]))
    bare = replace(before, envelope=EnvelopeEntry({}, {}))
    assert widened(bare, 0.2).standard_errors["N_ud"] == pytest.approx(0.2 * 0.04, rel=0.1)


@pytest.mark.parametrize("spread", [0.0, -0.1, float("nan"), float("inf")])
def test_a_spread_that_is_none_is_refused(before, spread):
    with pytest.raises(IdentificationError, match="expected a share above 0"):
        widened(before, spread)


@pytest.mark.system
def test_a_minute_with_the_old_model_is_worth_more_than_a_minute_alone(mp, before, after):
    """Three of them: errors in units of those of a minute alone."""
    truth, trials = after
    errors, others = [], []
    for trial in trials:
        record = trial.recording
        model = identify([record], mp, method="output-error", prior=before)
        alone = output_error([record], mp, start=before, settings=OutputErrorSettings(block=1.9))
        scale = np.array([alone.standard_errors[n] for n in truth])
        error, other = (np.array([m.values[n] - truth[n] for n in truth]) for m in (model, alone))
        assert np.all(np.abs(error) < 4 * np.array([model.standard_errors[n] for n in truth]))
        errors.append(error / scale)
        others.append(other / scale)
        old = np.array([before.values[n] - truth[n] for n in truth])
        assert np.sum((error / scale) ** 2) < 0.1 * np.sum((old / scale) ** 2)
        assert [r.name for r in model.recordings] == [record.name, "before"]
        assert model.estimator.settings["prior_spread"] == 0.2
        assert model.findings_of(*CONFLICTS) == ()
    assert np.sum(np.square(errors)) < 0.8 * np.sum(np.square(others))


def test_a_prior_that_is_too_sure_is_contradicted(mp, before, recording):
    model = identify([recording], mp, method="output-error", prior=before, prior_spread=0.02)
    texts = {f.subject[0]: finding_text(f) for f in model.findings_of(FindingKind.PRIOR_CONFLICT)}
    assert "X_F changed from 0.14 ± 0.0031 to 0.1" in texts["X_F"]
    assert "larger --prior-spread" in texts["X_F"]


def test_what_always_forward_does_not_show_stays_the_priors(before):
    af = seatrial.load_vehicle("mallard-af")
    trial = minute(load_plan("paper-like"), af)
    model = identify([trial.recording], af, method="output-error", prior=before)
    constants = dict(zip(model.vehicle.constants.names, model.constants, strict=True))
    assert constants["edge_reverse"] == pytest.approx(0.08, abs=1e-6)
    (dominated,) = model.findings_of(FindingKind.PRIOR_DOMINATES)
    assert "edge_reverse" in dominated.subject


def test_a_prior_of_other_terms_is_refused(mp, before, recording):
    lines = mp.structure.lines()
    lines["surge"] = ["X_u * |u| * u", "X_F * F_u"]
    other = vehicle_from(mp.to_mapping() | {"structure": lines}, "other")
    with pytest.raises(IdentificationError, match=r"X_u is X_u \* u in the prior"):
        check_prior(before, other)
    pose = mp.to_mapping()["pose"]
    moved = vehicle_from(mp.to_mapping() | {"pose": pose | {"lever": [0.15, 0.05]}}, "moved")
    words = r"of a point \[0.000, 0.000\] m .* file's of \[0.15, 0.05\]; write 'lever: \[0.000, 0.000\]'"
    with pytest.raises(IdentificationError, match=words):
        check_prior(before, moved)
    check_prior(before, moved, lever=True)
    plain = {k: v for k, v in mp.to_mapping().items() if k not in ("thrusters", "allocation")}
    with pytest.raises(
        IdentificationError, match="actuators are F_1, F_2, F_3, F_4, the vehicle file's F_u"
    ):
        check_prior(before, vehicle_from(plain, "plain"))
    still = replace(recording.commands, values=np.zeros_like(recording.commands.values))
    silent = replace(recording, commands=still)
    with pytest.raises(IdentificationError, match="nothing is commanded; drive"):
        identify([silent], mp, prior=before)
    lines["surge"] = ["X_uu * u * |u|", "X_u * u", "X_F * F_u"]
    check_prior(before, vehicle_from(mp.to_mapping() | {"structure": lines}, "same"))
    with pytest.raises(IdentificationError, match="belongs to output-error"):
        identify(
            [recording],
            mp,
            method="equation-error",
            prior=make_model(mp, TABLE_II["MP"]),
        )


def test_the_command_line(before, after, tmp_path, capsys):
    _, (trial, *_) = after
    seatrial.save(before, tmp_path / "old.yaml")
    run = str(write_trial(trial, tmp_path))
    line = [
        "identify", run, "--vehicle", "mallard-mp", "--prior", str(tmp_path / "old.yaml"),
        "-o", str(tmp_path / "new.yaml"), "--method", "output-error",
    ]  # fmt: skip
    assert main(line) == 0
    assert "prior: an older model, widened by 20 %" in capsys.readouterr().out
    out = done(capsys, "compare", tmp_path / "old.yaml", tmp_path / "new.yaml", run)
    assert "errors are not independent: both models come from before (B had an older model" in out
    assert "warning: B was identified from S7-MP" in out
    assert main([*line, "--bootstrap", "50"]) == 1
    assert "leave --prior out" in capsys.readouterr().err
    over = [*line[:-4], "-o", tmp_path / "old.yaml", *line[-2:]]
    assert "is an input of this command" in refused(capsys, *over)


def with_covariance(model, errors):
    """The model with these standard errors by name, the others as they are."""
    covariance = model.covariance.copy()
    for name, error in errors.items():
        k = model.parameters.index(name)
        covariance[k, :] = covariance[:, k] = 0.0
        covariance[k, k] = error**2
    return replace(model, covariance=covariance)


def test_what_the_prior_never_knew_takes_nothing_from_what_it_knew(mp, before, recording):
    """A thruster that was never used has an error without end: the others are known as before."""
    unknown = with_covariance(before, {"N_F": 1e10})
    found = identify([recording], mp, prior=unknown)
    whole = identify([recording], mp, prior=before)
    for name in ("X_u", "Y_vv", "Y_F", "lag"):
        assert found.standard_errors[name] == pytest.approx(whole.standard_errors[name], rel=0.1)
        assert found.standard_errors[name] < 1.2 * widened(before).standard_errors[name]
        assert found.values.get(name, 0.0) == pytest.approx(
            whole.values.get(name, 0.0), abs=whole.standard_errors[name]
        )


@pytest.mark.system
def test_a_prior_counts_where_the_data_ask_for_a_stage_that_it_has_not():
    """The library's `output_error(prior=...)`: what was freed began without the prior."""
    curved = {"lag": 0.15, "latency": 0.05, "power": 1.6}
    vehicle, long = driven(MIDDLE, curved, seed=3, white=2e-3)
    straight = output_error(long, vehicle, settings=OutputErrorSettings(select_stages=False))
    _, short = driven(MIDDLE, curved, seed=4, white=2e-3, drives=1)
    assert "power" in output_error(short, vehicle).vehicle.constants.names
    found = fit(short, vehicle, prior=straight)
    assert found.problem.prior is not None
    assert "power" not in found.problem.names


def test_a_bound_is_no_knowledge(mp, before, recording):
    """At a bound it is not known how well a parameter is known: the recording alone says what it is."""
    k = before.structure.coefficients.index("Y_vv")
    stuck = with_covariance(before, {"Y_vv": 0.0})
    coefficients = stuck.coefficients.copy()
    coefficients[k] = 0.0
    estimator = EstimatorEntry(
        "output-error", findings=[finding_of(FindingKind.AT_BOUND, "Y_vv", bound=0.0)]
    )
    stuck = replace(stuck, coefficients=coefficients, estimator=estimator)
    assert stuck.at_bounds == {"Y_vv"}
    assert widened(stuck).standard_errors["Y_vv"] == 0.0
    found = identify([recording], mp, prior=stuck)
    right = load_plan("hard").plant.coefficients["Y_vv"] / MORE
    assert found.values["Y_vv"] == pytest.approx(right, abs=4 * found.standard_errors["Y_vv"])
    assert found.values["Y_vv"] < 0.5 * right


def test_a_prior_that_has_seen_the_recording_is_said(before, mp, tmp_path):
    recording = seatrial.read(write_trial(minute(load_plan("hard"), mp), tmp_path), mp)
    seen = replace(before, recordings=(recording_entry(recording),))
    twice = FindingKind.PRIOR_COUNTED_TWICE
    (finding,) = identify([recording], mp, prior=seen).findings_of(twice)
    assert finding.subject == (recording.name,)
    assert identify([recording], mp, prior=before).findings_of(twice) == ()


def test_what_was_said_of_older_recordings_is_not_said_of_the_new_one(mp, before, recording):
    stays = [
        finding_of(FindingKind.CURVE_STAGE_SELECTED, stage="reverse_ratio"),
        finding_of(FindingKind.DEAD_ZONE_ONE_EDGE, "t1", side="astern"),
    ]
    thrust = {"quantity": "thrust", "change": 0.26, "dead_zone": "modelled"}
    goes = [
        finding_of(FindingKind.HOMOGENEITY, "yaw", "S3", "S1", **thrust),
        finding_of(FindingKind.PRIOR_USED, spread=0.6),
        finding_of(FindingKind.OUTLIERS, share=0.03),
        finding_of(FindingKind.AT_BOUND, "lag", bound=0.002),
        finding_of(FindingKind.OTHER, text="dead zone of bow: as an older version said"),
    ]
    entry = EstimatorEntry("output-error", findings=[goes[0], stays[0], *goes[1:], stays[1]])
    found = identify([recording], mp, prior=replace(before, estimator=entry))
    assert [f for f in found.estimator.findings if f in stays] == stays
    assert not [f for f in found.estimator.findings if f in goes]
    assert len(found.findings_of(FindingKind.PRIOR_USED)) <= 1
