# SPDX-License-Identifier: MIT
"""Shared boats, trials and recordings; with SEATRIAL_REQUIRE_ALL a skip is a failure."""

import fcntl
import gc
import importlib
import json
import os
import pickle
import shutil
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import bag_tools
import logs
import msgspec
import numpy as np
import pytest
from bag_tools import Sent
from cli_tools import done
from hypothesis import HealthCheck, settings
from report_pages import browser  # noqa: F401  a fixture
from shares import shared_out

import seatrial
from seatrial.boat.model_file import save
from seatrial.io.trial_files import write_setting, write_trial
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import Trial, plant_model, simulate
from seatrial.util import parallel

os.environ.pop("PYTHONUNBUFFERED", None)  # programs are run as users run them: a pipe has a buffer

settings.register_profile(
    "seatrial",
    derandomize="CI" in os.environ,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("seatrial")

# a run in the background of a shell ignores Ctrl-C, and so would the programs that tests start
signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).resolve().parents[1]
CSE1 = ROOT / "data" / "cse1"

GARBAGE = (
    20_000,
    20,
    20,
)  # new objects, and passes, between those of the collector: 5 % of the tests' time less

# Table II of the paper
TABLE_II = {
    "MP": {
        "X_u": -0.10, "X_uu": -1.67, "X_F": 0.15, "Y_v": -0.23, "Y_vv": -1.26, "Y_F": 0.26,
        "N_r": -0.73, "N_rr": -0.30, "N_F": 1.39, "N_ud": -0.14, "N_uu": 1.07,
    },
    "AF": {
        "X_u": -0.20, "X_uu": -1.74, "X_F": 0.14, "Y_v": -0.23, "Y_vv": -0.80, "Y_F": 0.20,
        "N_r": -0.48, "N_rr": -0.20, "N_F": 1.3, "N_ud": 0.04, "N_uu": 0.63,
    },
}  # fmt: skip


def pytest_configure():
    """A worker of a parallel run keeps to one core: the others have theirs. `on_cores` is for tests of threads."""
    if int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")) >= parallel.cores():
        parallel._most_cores.set(1)


def pytest_collection_finish():
    """What is collected stays: the garbage collector need not look through it during every test."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(*GARBAGE)


@pytest.fixture
def on_cores(monkeypatch):
    """Have as many cores as said, whatever the computer has."""

    def have(count: int) -> None:
        parallel._most_cores.set(count)
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(count)), raising=False)
        assert parallel.cores() == count

    before = parallel._most_cores.get()
    yield have
    parallel._most_cores.set(before)


def pytest_collection(session):
    """Each worker of a whole run imports its share first: pytest rewrites a file's asserts once, not once a worker."""
    name, count = (os.environ.get(f"PYTEST_XDIST_WORKER{end}", "") for end in ("", "_COUNT"))
    if name and [Path(path).name for path in session.config.args] == ["tests"]:
        for path in sorted(ROOT.glob("tests/test_*.py"))[
            int(name.removeprefix("gw")) :: int(count)
        ]:
            with suppress(Exception, pytest.skip.Exception):  # collecting it says so
                importlib.import_module(path.stem)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection_modifyitems(items):
    """What has no mark is a unit test. Of what is chosen, long files begin each worker's part."""
    for item in items:
        if not any(item.iter_markers("system")) and not any(item.iter_markers("study")):
            item.add_marker("unit")
    result = yield
    items[:] = shared_out(items, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))
    return result


def at_length(*values: object, **more: object) -> object:
    """Parameters of a case that only the system tests run: a unit test has another of its branch."""
    return pytest.param(*values, marks=pytest.mark.system, **more)


def on_request(*values: object, **more: object) -> object:
    """Another seed of a case that unit and system tests have, as studies run it."""
    return pytest.param(*values, marks=pytest.mark.study, **more)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if (
        report.skipped
        and not hasattr(report, "wasxfail")
        and os.environ.get("SEATRIAL_REQUIRE_ALL")
    ):
        report.outcome = "failed"
        report.longrepr = f"skipped, but SEATRIAL_REQUIRE_ALL is set: {report.longrepr}"
    return report


@pytest.fixture(scope="session")
def mp() -> seatrial.Vehicle:
    return seatrial.load_vehicle("mallard-mp")


@pytest.fixture(scope="session")
def af() -> seatrial.Vehicle:
    return seatrial.load_vehicle("mallard-af")


@pytest.fixture(scope="session")
def boat(mp) -> seatrial.Model:
    """The plant of the paper-like trials."""
    return in_coarse_steps(plant_model(load_plan("paper-like"), mp))


@pytest.fixture(scope="session")
def path(boat, tmp_path_factory) -> Path:
    """Its file."""
    path = tmp_path_factory.mktemp("boat") / "model.yaml"
    save(boat, path)
    return path


def trials(plan_name: str, vehicle: seatrial.Vehicle, share: float = 1.0) -> dict[str, Trial]:
    """Those of a plan, of so much of its time."""
    plan = load_plan(plan_name)
    lasting = {
        n: msgspec.structs.replace(t, duration=share * t.duration) for n, t in plan.trials.items()
    }
    plan = msgspec.structs.replace(plan, trials=lasting)
    return {t.name.split("-")[0]: t for t in simulate(plan, vehicle)}


@pytest.fixture(scope="session")
def once(tmp_path_factory):
    """What a function returns, or the folder that it fills: made by the first worker of a run that needs it."""
    root = tmp_path_factory.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root

    def get(name: str, make: Callable[[Path], Any]) -> tuple[Path, Any]:
        folder, result = root / f"once-{name}", root / f"once-{name}.pickle"
        with (root / f"once-{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not result.exists():
                folder.mkdir()
                result.write_bytes(pickle.dumps(make(folder)))
        return folder, pickle.loads(result.read_bytes())

    return get


def read_only(made: dict[str, Trial]) -> dict[str, Trial]:
    """Trials out of a file: their recordings' arrays again such that no test can change them for others."""
    for trial in made.values():
        for part in (trial.recording, trial.recording.commands):
            for value in vars(part).values():
                if isinstance(value, np.ndarray):
                    value.setflags(write=False)
    return made


@pytest.fixture(scope="session")
def clean_mp(mp, once) -> dict[str, Trial]:
    return read_only(once("clean-mp", lambda _: trials("clean", mp))[1])


@pytest.fixture(scope="session")
def clean_af(af, once) -> dict[str, Trial]:
    return read_only(once("clean-af", lambda _: trials("clean", af))[1])


@pytest.fixture(scope="session")
def paper_af(af, once) -> dict[str, Trial]:
    return read_only(once("paper-af", lambda _: trials("paper-like", af, 0.6))[1])


@pytest.fixture(scope="session")
def paper_mp(mp, once) -> dict[str, Trial]:
    return read_only(once("paper-mp", lambda _: trials("paper-like", mp, 0.6))[1])


@pytest.fixture(scope="session")
def paper_mp_model(mp, paper_mp, once) -> seatrial.Model:
    """Identified from S1-S3 by the default method."""
    recordings = [paper_mp[s].recording for s in ("S1", "S2", "S3")]
    return once("paper-mp-model", lambda _: seatrial.identify(recordings, mp))[1]


@pytest.fixture(scope="session")
def cse1_vehicle() -> seatrial.Vehicle:
    return seatrial.load_vehicle(CSE1 / "vehicle.yaml")


@pytest.fixture(scope="session")
def cse1(cse1_vehicle) -> dict[str, seatrial.Recording]:
    runs = ("random_run1", "random_run3", "run1")
    return {n: seatrial.read(CSE1 / "csv" / f"CSE1_data_{n}.csv", cse1_vehicle) for n in runs}


@pytest.fixture(scope="session")
def cse1_paper_model(cse1, cse1_vehicle, once) -> seatrial.Model:
    """The ship by the paper's method, from two runs."""
    runs = [cse1["random_run1"], cse1["random_run3"]]
    make = partial(seatrial.identify, runs, cse1_vehicle, method="equation-error")
    return once("cse1-paper-model", lambda _: make())[1]


@pytest.fixture(scope="module")
def pool(tmp_path_factory, af, paper_af, once):
    """Trials on disk, with a model identified from them."""

    def fill(out: Path) -> None:
        plan = load_plan("paper-like")
        write_setting(plan, af, plant_model(plan, af), out)
        records = [seatrial.read(write_trial(trial, out), af) for trial in paper_af.values()]
        save(seatrial.identify(records[:3], af), out / "model.yaml")

    out = tmp_path_factory.mktemp("pool")
    return Path(shutil.copytree(once("pool", fill)[0], out, dirs_exist_ok=True))


def in_coarse_steps(model: seatrial.Model) -> seatrial.Model:
    """The model integrated as identified ones are: its filters take an eighth of the time of a plant's."""
    integration = msgspec.structs.replace(model.integration, step=1 / 30)
    return replace(model, integration=integration)


def all_values(model):
    """Its coefficients and constants, by name."""
    constants = dict(zip(model.vehicle.constants.names, model.constants, strict=True))
    return {**model.values, **constants}


def make_model(
    vehicle: seatrial.Vehicle, values: dict[str, float], scheme="runge-kutta", step=1 / 30
):
    """A model with given coefficients and the vehicle's own chain."""
    from seatrial.boat.schema import EnvelopeEntry, Integration, NoiseEntry

    names = vehicle.structure.coefficients
    theta = np.array([values[name] for name in names])
    return seatrial.Model(
        vehicle, theta, np.diag((0.1 * theta) ** 2), vehicle.constants.values,
        Integration(scheme, step), NoiseEntry(0.0, 0.0), EnvelopeEntry({}, {}),
    )  # fmt: skip


@pytest.fixture(scope="module")
def sent() -> list[Sent]:
    """Three seconds of messages, for bags."""
    return bag_tools.drive(3.0)


@pytest.fixture(scope="module")
def log() -> logs.Log:
    """A drive whose sticks never ask for more than the thrusters can."""
    return logs.drive(sticks=logs.half)


@pytest.fixture
def propose(tmp_path, capsys):
    """`seatrial init` by the command line: the vehicle that its file describes, and the text."""

    def run(recording, *more):
        out = tmp_path / f"{recording.name}.yaml"
        shown = done(capsys, "init", recording, "-o", out, "-q", *more)
        text = out.read_text()
        assert text in shown
        assert f"wrote {out}\nnext: seatrial inspect {recording} --vehicle {out}" in shown
        return seatrial.load_vehicle(out), text

    return run


@pytest.fixture
def look(tmp_path, capsys):
    """`seatrial inspect` by the command line: what is shown, and the JSON beside."""

    def run(*recordings, vehicle=None, more=()):
        out = tmp_path / "inspect.json"
        extra = [] if vehicle is None else ["--vehicle", vehicle]
        shown = done(capsys, "inspect", *recordings, *extra, *more, "--json", out)
        return shown, json.loads(out.read_text(), parse_constant=pytest.fail)

    return run


@pytest.fixture
def inspected(look, tmp_path):
    """Write a log, inspect it with the mallard's file: the text, and the only recording's JSON."""

    def run(log, vehicle="mallard-mp", more=(), **types):
        text, found = look(log.write(tmp_path / "log.bag", **types), vehicle=vehicle, more=more)
        (recording,) = found["recordings"]
        return text, recording

    return run
