# SPDX-License-Identifier: MIT
"""Simulated trials: the paper's pool, operator and sensors, and a truth that belongs to them."""

import dataclasses

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, at_length, make_model, trials

import seatrial
from seatrial import _core
from seatrial.io.trial_files import write_setting, write_trial
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.simulation.plan import DisturbanceForce, TrialEntry, load_plan
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import ModelError
from tests.boats.plans import planned


def test_the_same_seed_gives_the_same_trials_and_another_seed_others(mp):
    plan = msgspec.structs.replace(load_plan("hard"), trials={"S1": TrialEntry("surge", 20.0)})
    first, again = (next(iter(simulate(plan, mp))) for _ in range(2))
    other = next(iter(simulate(msgspec.structs.replace(plan, seed=2), mp)))
    assert np.array_equal(first.pose, again.pose)
    assert np.array_equal(first.command, again.command)
    assert not np.array_equal(first.command[:1000], other.command[:1000])


def test_names_rates_and_lengths_are_the_papers(paper_af):
    assert list(paper_af) == ["S1", "S2", "S3", "S4", "S5", "S6", "S7"]
    lengths = [trial.duration for trial in load_plan("paper-like").trials.values()]
    assert lengths == [200.0] * 6 + [400.0]
    record = paper_af["S7"].recording
    assert 1 / record.period == pytest.approx(15.0, rel=1e-3)
    assert record.duration == pytest.approx(0.6 * 400.0, abs=0.5)
    steps = np.diff(record.seconds(record.commands.stamps))
    assert 1 / np.median(steps) == pytest.approx(100.0, rel=1e-6)


@pytest.mark.parametrize("seed", [1, at_length(2), at_length(3)])
def test_the_operator_keeps_half_a_metre_from_the_walls(mp, af, seed):
    plan = msgspec.structs.replace(load_plan("clean"), seed=seed)
    for vehicle in (mp, af):
        for trial in simulate(plan, vehicle):
            far = np.abs(trial.truth[:, :2]).max(axis=0)
            assert far[0] <= 3.6 / 2 - 0.5, trial.name
            assert far[1] <= 2.4 / 2 - 0.5, trial.name


def test_single_axis_trials_are_dominantly_that_axis_and_s7_is_mixed(clean_mp):
    from seatrial.recording.excitation import excitation

    found = [excitation(t.vehicle, t.recording) for t in clean_mp.values()]
    assert [e.dominant for e in found] == [0, 1, 2, 0, 1, 2, None]
    assert all(
        all(e.both_signs[i] for i in ([e.dominant] if e.dominant is not None else range(3)))
        for e in found
    )
    assert found[6].share.min() > 0.05


def test_the_truth_obeys_the_plant(af):
    """Re-simulating the logged commands through the true model returns the logged truth."""
    plan = load_plan("clean")
    trial = next(iter(simulate(plan, af)))
    truth = plant_model(plan, af)
    got, _ = _core.simulate(truth.boat, truth.trace(trial.recording), trial.truth[0], trial.truth_t)
    # sticks move at whole joypad ticks, so the log holds all that the boat was told
    np.testing.assert_allclose(got, trial.truth, atol=1e-6)
    np.testing.assert_allclose(
        truth.trace(trial.recording).forces(trial.truth_t), trial.truth_force, atol=1e-9
    )


def test_noise_jumps_drop_outs_and_clocks_are_as_asked(mp):
    plan = load_plan("hard")
    trial = trials("hard", mp)["S7"]
    error = trial.pose - trial.truth[trial.arrived, :3]
    error[:, 2] = (error[:, 2] + np.pi) % (2 * np.pi) - np.pi
    usual = np.abs(error[:, 0]) < 0.03
    assert error[usual, 0].std() == pytest.approx(0.004, rel=0.05)
    assert error[usual, 2].std() == pytest.approx(0.004, rel=0.2)
    assert 0 < (~usual).sum() < 40
    assert (~trial.arrived).sum() > 5
    jitter = trial.pose_stamps * 1e-9 - trial.truth_t[trial.arrived]
    assert jitter.std() == pytest.approx(plan.pose.stamp_jitter, rel=0.05)
    assert (trial.command_stamps[0] * 1e-9 + 0.5) == pytest.approx(
        plan.joypad.clock_offset, abs=1e-9
    )
    assert {FaultKind.EXCURSION, FaultKind.GAP} <= {f.kind for f in trial.recording.faults}


def autocorrelation(x, lag):
    return (x[lag:] * x[:-lag]).mean(axis=0) / (x**2).mean(axis=0)


def test_correlated_pose_noise_has_the_variance_and_the_memory_it_is_asked_for(mp):
    noise = {"position_noise": 0.002, "heading_noise": 0.004, "noise_correlation": 0.3}
    for trial in simulate(planned("clean", pose=noise), mp):
        if trial.name != "S7-MP":
            continue
        error = trial.pose - trial.truth[:, :3]
        error[:, 2] = (error[:, 2] + np.pi) % (2 * np.pi) - np.pi
        assert error.std(axis=0) == pytest.approx([0.002, 0.002, 0.004], rel=0.1)
        for lag in (1, 3, 6):
            want = np.exp(-lag / 15 / 0.3)
            assert autocorrelation(error, lag) == pytest.approx([want] * 3, abs=0.08)


@pytest.mark.system
def test_an_unmodelled_force_pushes_as_hard_and_as_long_as_it_is_asked_to(mp):
    """What the true model misses from pose to pose is the force's acceleration times the period."""
    plan = load_plan("clean")
    truth, missed = plant_model(plan, mp), []
    for trial in simulate(planned(plan, plant={"unmodelled": DisturbanceForce(0.04, 2.0)}), mp):
        ahead = seatrial.predict(truth, trial.recording, 1 / 15, velocities=trial.true_motion)
        missed.append(ahead.errors * 15)
    assert len(missed) == 7
    found = np.sqrt(np.mean([np.mean(m**2, axis=0) for m in missed], axis=0))
    c = plan.plant.coefficients
    assert found == pytest.approx([0.04 * c[n] for n in ("X_F", "Y_F", "N_F")], rel=0.1)
    memory = np.mean([autocorrelation(m, 30) for m in missed], axis=0)
    assert memory == pytest.approx([np.exp(-1)] * 3, abs=0.1)


def test_without_unmodelled_force_there_is_none(mp):
    plan = msgspec.structs.replace(load_plan("clean"), trials={"S1": TrialEntry("surge", 20.0)})
    pushed = planned(plan, plant={"unmodelled": DisturbanceForce(0.0, 2.0)})
    none, zero = (next(iter(simulate(p, mp))) for p in (plan, pushed))
    np.testing.assert_allclose(zero.truth, none.truth, atol=1e-7)  # other steps, same boat


def test_every_injected_false_match_is_masked_and_hardly_anything_else(mp):
    plan = load_plan("hard")
    jumps = msgspec.structs.replace(plan.pose.jumps, per_minute=3.0)
    for trial in simulate(planned(plan, pose={"jumps": jumps}), mp):
        off = np.hypot(*(trial.pose - trial.truth[trial.arrived, :3])[:, :2].T)
        bad = off > 0.08
        kept = trial.recording.valid
        assert not (kept & bad).any(), trial.name
        assert (~kept & ~bad).sum() <= 0.01 * len(kept), trial.name


def test_written_trials_read_back_as_the_same_recording(paper_af, tmp_path):
    for name in ("S1", "S7"):
        trial = paper_af[name]
        again = seatrial.read(write_trial(trial, tmp_path), trial.vehicle)
        assert np.abs(again.stamps - trial.recording.stamps).max() <= 1000  # [ns]
        np.testing.assert_allclose(again.eta, trial.recording.eta, atol=1e-6)
        assert np.array_equal(again.valid, trial.recording.valid)
        np.testing.assert_allclose(
            again.commands.values, trial.recording.commands.values, atol=1e-6
        )
        truth = np.loadtxt(tmp_path / "truth" / f"{trial.name}.csv", delimiter=",", skiprows=1)
        np.testing.assert_allclose(truth[:, 1:7], trial.truth, rtol=1e-6, atol=1e-9)


def test_the_written_vehicle_and_true_model_can_be_used(paper_af, af, tmp_path):
    plan = load_plan("paper-like")
    path = write_setting(plan, af, plant_model(plan, af), tmp_path)
    assert seatrial.load_vehicle(path).file == af.file
    truth = seatrial.load(tmp_path / "truth" / "model-AF.yaml")
    assert truth.values == pytest.approx(TABLE_II["AF"])
    assert load_plan(tmp_path / "truth" / "plan.yaml") == plan


def test_another_model_can_be_the_plant(mp, clean_mp):
    plan = msgspec.structs.replace(load_plan("clean"), trials={"S1": TrialEntry("surge", 20.0)})
    weak = make_model(mp, TABLE_II["MP"] | {"X_F": 0.05})
    (trial,) = simulate(plan, mp, weak)
    top = np.abs(trial.truth[:, 3]).max()
    assert top < 0.6 * np.abs(clean_mp["S1"].truth[:, 3]).max()


def test_a_plant_that_leaves_the_pool_or_has_other_terms_is_one_line(mp, cse1_vehicle):
    plan = load_plan("clean")
    with pytest.raises(ModelError, match="left the pool"):
        list(simulate(planned(plan, coefficients={"X_u": 1.0, "X_uu": 0.0}), mp))
    with pytest.raises(ModelError, match=r"the structure of .* disagree on .* --model MODEL"):
        next(iter(simulate(plan, cse1_vehicle)))
    with pytest.raises(ModelError, match="disagree on"):
        next(iter(simulate(planned(plan, plant={"coefficients": {"X_u": -1.0}}), mp)))


def test_trials_are_immutable(clean_mp):
    with pytest.raises(dataclasses.FrozenInstanceError):
        clean_mp["S1"].name = "x"
