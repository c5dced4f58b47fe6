# SPDX-License-Identifier: MIT
"""Before and after: tests with the false alarms they claim, changes found, predictions weighed."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, make_model
from estimates import estimated
from scipy import stats
from survey_boat import TRUTH as SURVEYED
from survey_boat import boat

from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.model_file import load, save
from seatrial.boat.schema import ChainGroup, DeadZone, RecordingEntry, SourceEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.evaluation.comparison.compare import compare, drive_of
from seatrial.evaluation.comparison.console import _factor as factor_text
from seatrial.evaluation.comparison.console import comparison_text
from seatrial.evaluation.comparison.parameters import Factor, factors, joint, pairs, views
from seatrial.util.errors import ModelError
from tests.boats.hulls import FREE, MIDDLE

MORE = 1.2  # times the mass
TRUTH = TABLE_II["AF"]
LOADED = {name: value / MORE for name, value in TRUTH.items()}


def names_of(found):
    return [pair.name for pair in found.changed]


@pytest.mark.system
def test_the_same_boat_twice_differs_in_one_comparison_out_of_twenty(mp):
    rng, runs = np.random.default_rng(7), 400
    alarms = np.zeros(4)
    for _ in range(runs):
        a, b = estimated(mp, TRUTH, rng), estimated(mp, TRUTH, rng)
        seen = views(a, b)
        found = pairs(a, b, seen, {})
        surge, _, yaw = factors(a, b, found, seen)
        alarms[0] += any(pair.differs for pair in found)
        alarms[1] += joint(found, seen).p < 0.05
        alarms[2] += surge.fits < 0.05
        alarms[3] += abs(yaw.z) > 1.96
    for number in alarms[1:]:
        assert stats.binomtest(int(number), runs, 0.05).pvalue > 0.001
    assert stats.binomtest(int(alarms[0]), runs, 0.05, "greater").pvalue > 0.001


def test_more_mass_is_one_factor_in_every_axis(mp):
    rng = np.random.default_rng(3)
    found = compare(estimated(mp, TRUTH, rng, 0.01), estimated(mp, LOADED, rng, 0.01))
    assert {"X_F", "Y_F", "N_F"} <= set(names_of(found))
    assert found.joint.p < 1e-6
    for factor in found.factors:
        assert factor.factor == pytest.approx(1 / MORE, abs=3 * factor.error)
        assert factor.error < 0.02
        assert factor.fits > 0.001
        assert "N_ud" not in factor.coefficients
    assert "20 % more mass" in comparison_text(compare(estimated(mp, TRUTH), estimated(mp, LOADED)))


def test_a_note_has_what_a_model_lacks_by_its_own_recordings(mp):
    """A weak thruster spoils the thrust curve of its model; the cause that fits this best need not be it."""
    a, b = estimated(mp, TRUTH), estimated(mp, LOADED)
    weak = finding_of(FindingKind.UNEQUAL_THRUSTER_GAINS, "T1", "T2", gains=(0.8, 1.2), weak="one")
    b = replace(b, estimator=msgspec.structs.replace(b.estimator, findings=(weak,)))
    (note,) = [n for n in compare(a, b).notes if "no cause allows for" in n]
    assert note.startswith("B's coefficients") and "unequal thruster gains of T1 and T2" in note
    assert note.endswith("identify again")


def test_a_payloads_coriolis_terms_take_no_part_in_the_factor(mp):
    """They are ratios of masses: with them a payload changed drag or thrust."""
    light, heavy = MIDDLE, replace(MIDDLE, mass=(15.0, 19.0, 0.9))
    boat = vehicle_from({**mp.to_mapping(), "structure": FREE}, "free")
    rng = np.random.default_rng(5)
    models = [estimated(boat, hull.coefficients, rng, 0.01) for hull in (light, heavy)]
    found = compare(*models)
    for factor, old, new in zip(found.factors, light.mass, heavy.mass, strict=True):
        assert factor.factor == pytest.approx(old / new, abs=3 * factor.error)
        assert factor.fits > 0.001
        assert not {"X_vr", "Y_ur", "N_uv"} & {*factor.coefficients}
    assert "by no common factor" not in comparison_text(found)


def test_what_one_model_never_knew_takes_no_part_in_the_factor(mp):
    rng = np.random.default_rng(3)
    a, b = estimated(mp, TRUTH, rng, 0.01), estimated(mp, LOADED, rng, 0.01)
    k = a.structure.coefficients.index("N_uu")
    covariance = a.covariance.copy()
    covariance[k, :] = covariance[:, k] = 0.0
    covariance[k, k] = 1e21
    found = compare(replace(a, covariance=covariance), b)
    yaw = found.factors[2]
    assert "N_uu" not in yaw.coefficients
    assert yaw.factor == pytest.approx(1 / MORE, abs=3 * yaw.error)
    assert yaw.error < 0.03


def test_more_drag_alone_is_no_change_of_mass(mp):
    found = compare(estimated(mp, TRUTH), estimated(mp, TRUTH | {"X_u": -0.4, "X_uu": -2.6}))
    assert names_of(found) == ["X_u", "X_uu"]
    assert found.factors[0].fits < 1e-6
    text = comparison_text(found)
    assert "surge: X_u, X_uu, X_F changed by no common factor" in text
    assert "sway:" not in text


def test_differences_are_in_units_of_both_errors(mp):
    a, b = estimated(mp, TRUTH), estimated(mp, TRUTH | {"X_F": 0.15})
    pair = next(p for p in compare(a, b).pairs if p.name == "X_F")
    error = np.hypot(a.standard_errors["X_F"], b.standard_errors["X_F"])
    assert (pair.difference, pair.error) == pytest.approx((0.01, error))
    assert pair.z == pytest.approx(0.01 / error)
    assert pair.unit == "m/s^2"
    raw = 2 * stats.norm.sf(pair.z)
    assert pair.p == pytest.approx(11 * raw)


def test_the_joint_test_is_the_quadratic_form(mp):
    rng = np.random.default_rng(5)
    a, b = estimated(mp, TRUTH, rng), estimated(mp, TRUTH, rng)
    d = b.coefficients - a.coefficients
    want = d @ np.linalg.solve(a.covariance[:11, :11] + b.covariance[:11, :11], d)
    found = compare(a, b).joint
    assert found.chi2 == pytest.approx(want, rel=1e-8)
    assert found.p == pytest.approx(stats.chi2.sf(want, 11), rel=1e-8)


def test_given_values_are_compared_without_a_test(mp):
    a, b = (replace(make_model(mp, v), covariance=np.zeros((11, 11))) for v in (TRUTH, LOADED))
    found = compare(a, b)
    assert found.joint is None
    assert found.factors == []
    assert len(found.changed) == 11
    assert "Nothing was estimated" in comparison_text(found)


def with_edge(model, edge, error):
    """The model with a dead zone in its chain."""
    vehicle = model.vehicle.with_chain([ChainGroup(dead_zone=DeadZone(edge, edge))])
    covariance = np.zeros((13, 13))
    covariance[:11, :11] = model.covariance[:11, :11]
    covariance[11, 11] = covariance[12, 12] = error**2
    constants = vehicle.constants.values
    return replace(model, vehicle=vehicle, constants=constants, covariance=covariance)


def test_always_forwards_gain_is_compared_past_the_dead_zones_edge(mp, af):
    gains = {n: v / 0.92 if n.endswith("_F") else v for n, v in TRUTH.items()}
    a, b = with_edge(estimated(mp, TRUTH), 0.08, 0.01), estimated(af, gains)
    found = compare(a, b)
    assert found.changed == []
    assert found.joint.chi2 == pytest.approx(0.0, abs=1e-12)
    pair = next(p for p in found.pairs if p.name == "X_F")
    scatter = np.hypot(a.standard_errors["X_F"] / 0.92, TRUTH["X_F"] / 0.92**2 * 0.01)
    assert pair.a == pytest.approx(TRUTH["X_F"] / 0.92)
    assert pair.error_a == pytest.approx(scatter)
    assert [one.name for one in found.only_a] == ["edge_forward", "edge_reverse"]
    text = comparison_text(found)
    assert "A's are shown as X_F, Y_F, N_F / (1 - edge)" in text
    assert "allocation: A moore-penrose, B always-forward with F_os 0.12" in text
    turned = compare(b, a)
    assert [(p.a, p.b) for p in turned.pairs] == [(p.b, p.a) for p in found.pairs]
    plain = comparison_text(compare(a, estimated(mp, TRUTH)))
    assert "A has a dead zone, B has none: B's thrust gains are an average over it" in plain


def changed(vehicle, **keys):
    return vehicle_from(vehicle.to_mapping() | keys, "changed")


def test_terms_of_one_model_and_same_names_with_another_meaning_are_said(mp):
    lines = mp.structure.lines()
    lines["surge"] = ["v * r", "X_u * u", "X_uu * |v| * u", "X_F * F_u", "X_v * v"]
    other = make_model(changed(mp, structure=lines), TRUTH | {"X_v": -0.1})
    found = compare(make_model(mp, TRUTH), other)
    assert [one.name for one in found.only_b] == ["X_uu", "X_v"]
    assert "it is X_uu * |u| * u in A, X_uu * |v| * u in B" in comparison_text(found)
    lines["surge"][0] = "0.9 * v * r"
    fixed = make_model(changed(mp, structure=lines), TRUTH | {"X_v": -0.1})
    assert any("without a coefficient differ" in n for n in compare(other, fixed).notes)


def test_two_origins_are_said_and_recordings_are_not_predicted_by_both(mp):
    pose = mp.to_mapping()["pose"]
    moved = changed(mp, pose=pose | {"lever": [0.15, 0.05]})
    a, b = make_model(moved, TRUTH), make_model(mp, TRUTH)
    notes = compare(a, b).notes
    assert any(
        "two origins: the measured point is 0.150 m ahead and 0.050 m to port" in n for n in notes
    )
    for vehicle in (None, mp):
        with pytest.raises(ModelError, match=r"of two origins .* identify both with one lever arm"):
            drive_of(a, b, vehicle)
    near = make_model(changed(mp, pose=pose | {"lever": [0.0004, 0.0]}), TRUTH)
    assert not any("origins" in n for n in compare(near, b).notes)


@pytest.mark.parametrize("factor", [0.0, -0.4, 1e-9])
def test_a_factor_that_no_mass_makes_is_another_boat(factor):
    (said,) = factor_text(Factor("surge", ["X_u", "X_F"], factor, 1e-4, (factor - 1) / 1e-4, 1.0))
    assert said.endswith("too much for a change of mass; check that both are of the same boat.")


def test_what_ended_at_a_bound_is_not_tested(mp):
    a, b = estimated(mp, TRUTH), estimated(mp, TRUTH | {"X_uu": 0.0})
    ended = [finding_of(FindingKind.AT_BOUND, "X_uu", bound=0.0)]
    b = replace(b, estimator=msgspec.structs.replace(b.estimator, findings=ended))
    found = compare(a, b)
    assert "X_uu" not in [pair.name for pair in found.pairs]
    assert found.joint is not None
    assert found.joint.p > 0.99
    assert "X_uu" in [one.name for one in found.only_b]
    told = [t for t in comparison_text(found).splitlines() if "X_uu" in t and "only" in t]
    assert [line.split()[0] for line in told] == ["X_uu", "X_uu"]
    assert all("it is at the bound of its range in B" in line for line in told)
    assert not any("given" in line for line in told)


def test_models_with_nothing_in_common_are_refused(mp):
    lines = {"surge": ["X_a * u", "X_b * F_u"]}
    other = make_model(changed(mp, structure=lines), {"X_a": -1.0, "X_b": 1.0})
    with pytest.raises(ModelError, match=r"no coefficient in common: A has X_u.*B has X_a, X_b"):
        compare(make_model(mp, TRUTH), other)


def test_other_axes_are_converted(mp, tmp_path):
    """The same boat in a file of the other axes: no difference, and a note."""
    frd = changed(mp, axes="forward-right-down")
    save(estimated(mp, TRUTH), tmp_path / "a.yaml")
    save(estimated(frd, TRUTH), tmp_path / "b.yaml")
    assert "N_uu" in (tmp_path / "b.yaml").read_text()
    a, b = (load(tmp_path / f"{n}.yaml") for n in "ab")
    found = compare(a, b)
    assert found.changed == []
    assert any("both are compared in forward-left-up axes" in note for note in found.notes)


def entry(name, sha, start=0.0):
    return RecordingEntry(name, 60.0, start, [SourceEntry(f"{name}.bag", sha)])


def test_shared_recordings_make_errors_dependent_and_it_is_said(mp):
    a, b = estimated(mp, TRUTH), estimated(mp, TRUTH)
    one = replace(a, recordings=(entry("S1", "x"), entry("S2", "y")))
    other = replace(b, recordings=(entry("renamed", "y", 30.0), entry("S1", "z")))
    (note,) = compare(one, other).notes
    assert note.startswith("errors are not independent: both models come from S2.")
    later = replace(b, recordings=(entry("renamed", "y", 60.0), entry("S1", "z")))
    assert compare(one, later).notes == []


def test_the_boat_in_physical_words(mp):
    """Mass alone leaves top speed, and makes way and time to it longer by as much."""
    found = compare(make_model(mp, TRUTH), make_model(mp, LOADED))
    for row in found.boat[:2]:
        assert row.top_speed[1] == pytest.approx(row.top_speed[0], rel=1e-6)
        assert row.rise_time[1] == pytest.approx(MORE * row.rise_time[0], abs=0.01)
        assert row.coast[1] == pytest.approx(MORE * row.coast[0], rel=2e-3)
    unstable = make_model(mp, TRUTH | {"X_u": 0.5, "X_uu": 0.0})
    with pytest.raises(ModelError, match=r"B: .*unstable"):
        compare(make_model(mp, TRUTH), unstable)


def test_models_are_driven_as_the_recordings_were(mp, af):
    frd = changed(mp, axes="forward-right-down")
    a, b = make_model(mp, TRUTH), make_model(af, LOADED)
    driven = drive_of(a, b, frd)
    for model, own in zip(driven, (a, b), strict=True):
        assert model.vehicle.file.allocation == frd.file.allocation
        assert model.values == own.values
        assert set(model.structure.terms) == set(own.structure.terms)


def test_long_names_of_parameters_keep_the_columns():
    """Of groups: under the heads of the table, which stand at the ends of their columns."""
    name = "of_the_outboard_on_the_port_side"
    both = []
    for lag in (0.1, 0.2):
        vehicle = boat([{"name": name, "actuators": ["left"], "lag": lag}])
        model = make_model(vehicle, {n: SURVEYED[n] for n in vehicle.structure.coefficients})
        size = len(model.parameters)
        both.append(replace(model, covariance=1e-4 * np.eye(size)))
    lines = comparison_text(compare(*both)).splitlines()
    (head,) = (line for line in lines if "p (Holm)" in line)
    rows = [line for line in lines if line[2:].startswith((f"lag.{name}", "X_u "))]
    assert len(rows) == 2
    for row in rows:
        for column in (" A", " B", "B - A"):
            end = head.index(f"{column} ") + len(column)
            assert row[end - 1] != " " and row[end : end + 1] in (" ", ""), row
