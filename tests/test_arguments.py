# SPDX-License-Identifier: MIT
"""Arguments of public functions: one line for a wrong type or value, and what their results show of themselves."""

import dataclasses
import inspect
import pickle
import re
import typing

import numpy as np
import pytest

import seatrial
from seatrial.control import Eight, fitted
from seatrial.control.tracking.reference import Reference
from seatrial.export import export
from seatrial.util.errors import (
    AllocationError,
    ControlError,
    IdentificationError,
    ModelError,
    PredictorError,
    RecordingError,
    SeatrialError,
)


@pytest.fixture(scope="module")
def runs(paper_mp):
    return [paper_mp[name].recording for name in ("S1", "S2", "S3")]


NAMES = [getattr(seatrial, name) for name in seatrial.__all__]
RETURNED = [typing.get_type_hints(f)["return"] for f in NAMES if inspect.isfunction(f)]
PUBLIC = [
    kind
    for kind in dict.fromkeys([*NAMES, *RETURNED])
    if inspect.isclass(kind) and kind.__module__ != "builtins"
]


@pytest.mark.parametrize("kind", PUBLIC, ids=lambda kind: kind.__name__)
def test_help_says_what_each_field_is(kind):
    fields = getattr(kind, "__struct_fields__", ())
    if dataclasses.is_dataclass(kind):
        fields = [field.name for field in dataclasses.fields(kind) if field.init]
    said = re.findall(r"^(\w+): .", inspect.getdoc(kind), re.MULTILINE)
    assert [name for name in said if name in fields] == list(fields)


REST = Reference(np.zeros(3), np.zeros(3), np.zeros(3))
CALLS = {  # a call with an argument of another type, and the beginning of what it says
    "a path for a vehicle": (
        lambda m, r: seatrial.read("run1", "vehicle.yaml"),
        "vehicle 'vehicle.yaml': expected a Vehicle, from seatrial.load_vehicle(path)",
    ),
    "a model for a vehicle": (
        lambda m, r: seatrial.identify(r, m),
        "vehicle of type Model: expected a Vehicle, from seatrial.load_vehicle(path)",
    ),
    "one recording to identify from": (
        lambda m, r: seatrial.identify(r[0], m.vehicle),
        "recordings of type Recording: expected a list, [...]",
    ),
    "paths to identify from": (
        lambda m, r: seatrial.identify(["run1"], m.vehicle),
        "recordings 'run1': expected a Recording, from seatrial.read(path, vehicle)",
    ),
    "a path for a prior": (
        lambda m, r: seatrial.identify(r, m.vehicle, prior="old.yaml"),
        "prior 'old.yaml': expected a Model",
    ),
    "one effect without a list": (
        lambda m, r: seatrial.identify(r, m.vehicle, effects="lever"),
        "effects 'lever': expected a list",
    ),
    "one name for a role": (
        lambda m, r: seatrial.identify(
            r, m.vehicle, method="equation-error", roles={"surge": "S1-MP"}
        ),
        "role surge 'S1-MP': expected a list",
    ),
    "settings as a dict": (
        lambda m, r: seatrial.identify(
            r, m.vehicle, method="equation-error", settings={"literal": True}
        ),
        "settings of type dict: expected a EquationErrorSettings",
    ),
    "recordings to predict": (seatrial.predict, "recording of type list: expected a Recording"),
    "a path for a model": (
        lambda m, r: seatrial.predict("model.yaml", r[0]),
        "model 'model.yaml': expected a Model, from seatrial.load(path) or identify(...)",
    ),
    "one recording to validate on": (
        lambda m, r: seatrial.validate(m, r[0]),
        "recordings of type Recording: expected a list",
    ),
    "another model by its path": (
        lambda m, r: seatrial.validate(m, r, other="old.yaml"),
        "other 'old.yaml': expected a Model",
    ),
    "an iterator of recordings": (
        lambda m, r: seatrial.validate(m, iter(r)),
        "recordings of type list_iterator: expected a list",
    ),
    "recordings to inspect by their paths": (
        lambda m, r: seatrial.inspect(["run1"], m.vehicle),
        "recordings 'run1': expected a Recording",
    ),
    "velocities of several": (
        lambda m, r: seatrial.motion(r),
        "recording of type list: expected a Recording",
    ),
    "a plan by its name": (
        lambda m, r: seatrial.simulate("paper-like", m.vehicle),
        "plan 'paper-like': expected a PlanFile, from seatrial.load_plan(path)",
    ),
    "models to compare by their paths": (
        lambda m, r: seatrial.compare(m, "new.yaml"),
        "b 'new.yaml': expected a Model",
    ),
    "a model to tune by its path": (
        lambda m, r: seatrial.tune("model.yaml"),
        "model 'model.yaml': expected a Model",
    ),
    "a boat to allocate by its path": (
        lambda m, r: seatrial.Allocator("model.yaml"),
        "boat 'model.yaml': expected a Model or Vehicle",
    ),
    "no model on board": (
        lambda m, r: seatrial.Predictor(None),
        "model None: expected a Model or str or Path",
    ),
    "a vehicle for a model on board": (
        lambda m, r: seatrial.Odometer(m.vehicle),
        "model of type Vehicle: expected a Model or str or Path",
    ),
    "a path for a model to save": (
        lambda m, r: seatrial.save("model.yaml", m),
        "model 'model.yaml': expected a Model",
    ),
    "a model to export by its path": (
        lambda m, r: export("model.yaml", "c", "boat.h"),
        "model 'model.yaml': expected a Model",
    ),
    "another vehicle by its path": (
        lambda m, r: m.with_vehicle("vehicle.yaml"),
        "vehicle 'vehicle.yaml': expected a Vehicle",
    ),
    "one log": (lambda m, r: seatrial.auto("run1.bag", "out"), "logs 'run1.bag': expected a list"),
    "a reference as numbers": (
        lambda m, r: seatrial.TrackingController(seatrial.tune(m)).command(
            0.0, [0, 0, 0], [0, 0, 0], [0, 0, 0]
        ),
        "reference of type list: expected a Reference",
    ),
}


@pytest.mark.parametrize("case", CALLS)
def test_an_argument_of_another_type_is_one_line_that_says_how_to_get_it(
    case, runs, paper_mp_model
):
    call, expected = CALLS[case]
    with pytest.raises(SeatrialError) as error:
        call(paper_mp_model, runs)
    assert str(error.value).startswith(expected)
    assert isinstance(error.value, TypeError)


WRONG = {
    "a role of no axis": (
        RecordingError,
        lambda m, r: seatrial.identify(r, m.vehicle, method="equation-error", roles={"heave": ["S1-MP"]}),
        "no role heave; there are surge, sway, yaw",
    ),
    "settings of another method": (
        IdentificationError,
        lambda m, r: seatrial.identify(r, m.vehicle, settings=seatrial.EquationErrorSettings()),
        "belongs to equation-error, not to output-error",
    ),
    "a correlation that is none": (
        IdentificationError,
        lambda m, r: seatrial.EquationErrorSettings(correlation=float("nan")),
        "correlation nan s: expected 0 or more",
    ),
    "no recording to inspect": (
        RecordingError,
        lambda m, r: seatrial.inspect([], m.vehicle),
        "no recording given",
    ),
    "every 0th pose": (
        RecordingError,
        lambda m, r: seatrial.predict(m, r[0], every=0),
        "every 0: expected a whole number of poses from 1 on",
    ),
    "every 1.5th pose": (
        RecordingError,
        lambda m, r: seatrial.predict(m, r[0], every=1.5),
        "every 1.5: expected a whole number",
    ),
    "an unknown reference": (
        RecordingError,
        lambda m, r: seatrial.validate(m, r, reference="truth"),
        "reference 'truth': expected one of smoothed, stencil",
    ),
    "an unknown action": (
        ControlError,
        lambda m, r: seatrial.tune(m, action="p"),
        "action 'p': expected one of pid, pd",
    ),
    "fewer draws than none": (
        ControlError,
        lambda m, r: seatrial.tune(m, draws=-1),
        "draws -1: expected 0 or more",
    ),
    "a wrench of letters": (
        AllocationError,
        lambda m, r: seatrial.Allocator(m).allocate("abc"),
        "wrench 'abc'; expected (3,) or (m, 3) numbers",
    ),
    "a rate of 0": (RecordingError, lambda m, r: r[0].thinned(0.0), "rate 0.0 Hz: expected a number above 0"),
    "no windows": (
        ModelError,
        lambda m, r: seatrial.ChangeDetector(m, lengths=()),
        "expected numbers above 0",
    ),
    "an input of no kind": (
        PredictorError,
        lambda m, r: seatrial.ChangeDetector(m).use("cmd", 0, [0, 0, 0]),
        "no kind 'cmd'; there are pose, position, heading, command, scale",
    ),
    "a command of two numbers": (
        PredictorError,
        lambda m, r: seatrial.ChangeDetector(m).use("command", 0, [0, 0]),
        "command of shape (2,); expected 3 numbers: F_u, F_v, F_r",
    ),
    "a course of no length": (
        ControlError,
        lambda m, r: fitted(Eight(1.1, 0.45, laps=0), m),
        "course of length 0: expected more than 0",
    ),
    "a stamp in seconds": (
        PredictorError,
        lambda m, r: seatrial.Odometer(m).at(12.5),
        "stamp 12.5: expected whole nanoseconds",
    ),
    "a pose of two numbers": (
        PredictorError,
        lambda m, r: seatrial.TrackingController(seatrial.tune(m)).command(0.0, [0, 0], [0, 0, 0], REST),
        "eta of shape (2,); expected 3 numbers: x, y, psi",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_a_value_without_a_meaning_is_refused(case, runs, paper_mp_model):
    kind, call, expected = WRONG[case]
    with pytest.raises(kind) as error:
        call(paper_mp_model, runs)
    assert expected in str(error.value)


def test_values_units_and_errors_of_a_model_have_the_same_names(paper_mp_model):
    model = paper_mp_model
    assert list(model.parameter_values) == list(model.standard_errors) == list(model.parameters)
    assert set(model.units) == set(model.parameters)
    assert model.parameter_values["X_u"] == model.values["X_u"] == model.coefficients[0]
    assert model.parameter_values["lag"] == model.constants[-1]
    assert (model.units["X_u"], model.units["lag"]) == ("1/s", "s")


def test_print_shows_what_the_command_line_shows(runs, paper_mp_model):
    model = paper_mp_model
    tuned, scores = seatrial.tune(model), seatrial.validate(model, runs[:1])
    for shown, words in (
        (model, ("X_u", "±", "1/s")),
        (scores, ("RMS error 1 s ahead", "expected", "RMS error ahead")),
        (seatrial.inspect(runs[:1], model.vehicle), ("S1-MP", "quality")),
        (seatrial.compare(model, model), ("B - A", "X_u")),
        (tuned, ("surge", "full command")),
    ):
        assert all(word in str(shown) for word in words), str(shown)
    for one in (model, model.vehicle, runs[0], tuned):
        assert len(repr(one)) < 200, repr(one)
        assert "\n" not in repr(one)


def test_data_with_arrays_are_in_lists_and_sets_and_pickled(runs, paper_mp_model):
    a, b, c = runs
    assert [a, b, c].index(c) == 2
    assert len({a, b, c, a}) == 3
    assert (paper_mp_model == pickle.loads(pickle.dumps(paper_mp_model))) is False
    again = pickle.loads(pickle.dumps(a))
    np.testing.assert_array_equal(again.eta, a.eta)
