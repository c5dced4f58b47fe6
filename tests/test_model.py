# SPDX-License-Identifier: MIT
"""The model file: what is written is what is read, and nothing else is read."""

import itertools
from dataclasses import replace

import msgspec
import numpy as np
import pytest
import yaml
from conftest import TABLE_II, make_model

import seatrial
from seatrial import _core
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.model_file import load, save
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.boat.vehicle import vehicle_from
from seatrial.util.errors import FileError, ModelError, SeatrialError


@pytest.fixture(scope="module")
def identified(clean_af, af):
    records = [clean_af[s].recording for s in ("S1", "S2", "S3")]
    return seatrial.identify(records, af, method="equation-error")


def same(a, b):
    np.testing.assert_allclose(a.coefficients, b.coefficients, rtol=1e-9)
    np.testing.assert_allclose(a.covariance, b.covariance, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(a.constants, b.constants, rtol=1e-9)
    assert a.structure.terms == b.structure.terms
    assert a.integration.scheme == b.integration.scheme
    assert a.integration.step == pytest.approx(b.integration.step, rel=1e-9)
    assert [r.name for r in a.recordings] == [r.name for r in b.recordings]
    assert (
        a.estimator.steps[0].recordings == b.estimator.steps[0].recordings
        if a.estimator.steps
        else True
    )
    assert a.warnings == b.warnings
    np.testing.assert_allclose(a.vehicle.mix, b.vehicle.mix, atol=1e-12)


def test_a_model_survives_its_file(identified, tmp_path):
    path = tmp_path / "model.yaml"
    save(identified, path)
    again = load(path)
    same(identified, again)
    save(again, tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_text() == path.read_text()


def test_a_parameter_at_its_bound_is_known_by_any_name(mp):
    """Names of groups are the owner's: a colon in one is not the end of it."""
    lagged = mp.with_chain([ChainGroup(name="fast: 1", lag=0.05)])
    model = make_model(lagged, TABLE_II["AF"])
    ended = [finding_of(FindingKind.AT_BOUND, "lag.fast: 1", bound=0.002)]
    model = replace(model, estimator=msgspec.structs.replace(model.estimator, findings=ended))
    assert model.at_bounds == {"lag.fast: 1"}


def frd(vehicle: seatrial.Vehicle) -> seatrial.Vehicle:
    """The same boat described in forward-right-down axes."""
    content = vehicle.to_mapping()
    content["axes"] = "forward-right-down"
    for thruster in content.get("thrusters", {}).values():
        thruster["y"] *= -1
        thruster["angle_deg"] *= -1
    return vehicle_from(content, "frd")


def test_a_model_in_forward_right_down_axes_survives_its_file(mp, tmp_path):
    chain = [ChainGroup(latency=0.02, dead_zone=DeadZone(0.08, 0.09), lag=0.1)]
    model = make_model(frd(mp).with_chain(chain), TABLE_II["MP"])
    save(model, tmp_path / "frd.yaml")
    same(model, load(tmp_path / "frd.yaml"))
    written = yaml.safe_load((tmp_path / "frd.yaml").read_text())["coefficients"]
    assert written["N_ud"]["value"] == pytest.approx(+0.14)  # one of the two that change sign
    assert written["N_r"]["value"] == pytest.approx(-0.73)


def edit(path, change):
    content = yaml.safe_load(path.read_text())
    change(content)
    path.write_text(yaml.safe_dump(content))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.update(seatrial="model 4"), "says 'seatrial: model 4'"),
        (lambda c: c.update(seatrial="vehicle 1"), "says 'seatrial: vehicle 1'"),
        (lambda c: c.update(colour="red"), "unknown key 'colour'"),
        (lambda c: c["coefficients"].pop("X_u"), "disagree on X_u"),
        (lambda c: c["coefficients"].update(Y_x={"value": 1.0, "standard_error": 1.0}), "disagree on Y_x"),
        (lambda c: c["coefficients"]["X_u"].update(value="fast"), r"coefficients\.X_u\.value: expected a number, got text"),
        (lambda c: c["coefficients"]["X_u"].update(value=float("nan")), "finite"),
        (lambda c: c["covariance"].pop(), "11 x 11"),
        (lambda c: c["covariance"][0].__setitem__(0, -1.0), "variances >= 0"),
        (lambda c: c["covariance"][0].__setitem__(1, 9.0), "symmetric"),
        (lambda c: [c["covariance"][i].__setitem__(1 - i, 9.0) for i in (0, 1)], "negative eigenvalue"),
        (lambda c: c["coefficients"]["X_u"].update(standard_error=-1.0), r"X_u\.standard_error"),
        (lambda c: c["coefficients"]["X_u"].update(unit="kg"), "X_u is in 'kg'; it must be in '1/s'"),
        (lambda c: c.update(axes="forward-right-down"), "its vehicle's are"),
        (lambda c: c.update(constants={"lag": {"value": 0.1, "standard_error": 0.0}}), "disagree on lag"),
        (lambda c: c["integration"].update(step=0.0), "integration"),
        (lambda c: c["vehicle"].update(axis="x"), "unknown key 'axis'"),
        (lambda c: c.pop("noise"), "key 'noise' is missing"),
    ],
)  # fmt: skip
def test_a_model_file_that_is_not_right_is_one_clear_line(identified, tmp_path, change, words):
    path = tmp_path / "model.yaml"
    save(identified, path)
    edit(path, change)
    with pytest.raises(SeatrialError, match=words) as caught:
        load(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("lag", -0.1, "lag is -0.1; expected a number >= 0"),
        ("latency", 8.0, "latency is 8; expected a number <= 5"),
        ("edge_forward", 1.2, "edge_forward is 1.2; expected a number < 1"),
        ("edge_reverse", -0.2, "edge_reverse is -0.2; expected a number >= 0"),
    ],
)
def test_a_constant_that_no_vehicle_file_may_state_is_refused(mp, tmp_path, name, value, words):
    path = tmp_path / "model.yaml"
    chain = [ChainGroup(latency=0.02, dead_zone=DeadZone(0.08, 0.09), lag=0.1)]
    save(make_model(mp.with_chain(chain), TABLE_II["MP"]), path)
    load(path)
    edit(path, lambda content: content["constants"][name].update(value=value))
    with pytest.raises(ModelError, match=words):
        load(path)


def test_another_vehicle_can_read_other_recordings_of_the_boat(identified, mp):
    other = identified.with_vehicle(mp)
    assert other.vehicle.scheme is mp.scheme
    assert np.array_equal(other.coefficients, identified.coefficients)


def test_another_vehicle_keeps_the_models_actuator_chain(mp, af):
    chain = [ChainGroup(latency=0.02, dead_zone=DeadZone(0.08, 0.09), lag=0.1)]
    model = make_model(mp.with_chain(chain), TABLE_II["MP"]).with_vehicle(af)
    assert model.vehicle.scheme is af.scheme
    assert model.vehicle.constants.names == ("latency", "edge_forward", "edge_reverse", "lag")
    assert model.constants.tolist() == [0.02, 0.08, 0.09, 0.1]


def test_another_vehicle_must_have_the_same_terms(identified, cse1_vehicle):
    with pytest.raises(ModelError, match="the model has X_u"):
        identified.with_vehicle(cse1_vehicle)


def test_the_order_of_a_vehicles_terms_does_not_matter(identified, mp):
    lines = {axis: terms[::-1] for axis, terms in mp.structure.lines().items()}
    turned = replace(mp, file=msgspec.structs.replace(mp.file, structure=lines))
    other = identified.with_vehicle(turned)
    assert other.structure.coefficients != identified.structure.coefficients
    assert other.values == identified.values
    assert other.standard_errors == identified.standard_errors
    for one, two in itertools.product(other.parameters, repeat=2):
        assert covered(other, one, two) == covered(identified, one, two)
    nu, forces = np.array([[0.4, -0.2, 0.6]]), np.array([[0.5, 0.3, -0.2]])
    now, then = (
        _core.accelerations(m.structure.compiled, m.coefficients, nu, forces)
        for m in (other, identified)
    )
    np.testing.assert_allclose(now, then, rtol=1e-12)


def covered(model, one, two):
    return model.covariance[model.parameters.index(one), model.parameters.index(two)]


def test_a_missing_model_is_one_line(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        load(tmp_path / "none.yaml")
