# SPDX-License-Identifier: MIT
"""Many boats at once: the same table whoever did the work, what fails in its row, nothing done twice."""

import json
import os
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from platform import node

import msgspec
import psutil
import pytest
from cli_tools import done, run
from waiting import PATIENCE, until

from seatrial.boat.vehicle import load_vehicle
from seatrial.fleet import dask_cluster
from seatrial.fleet.dask_cluster import cluster
from seatrial.fleet.fleet import fleet
from seatrial.fleet.fleet_file import load_fleet
from seatrial.fleet.results import FleetResult
from seatrial.io.trial_files import write_setting, write_trial
from seatrial.simulation.plan import TrialEntry, load_plan, with_seed
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import FleetError
from seatrial.util.parallel import InTurn, cores, farmed, on_one_core, working_on

FIRST = "first"
SECONDS = 40.0  # of each recording


def boat(folder, seed, *, heavier=1.0, seconds=SECONDS, coarse=False):
    """Three short recordings of a boat, and its vehicle file. `heavier`: times the mass; `coarse`: few poses."""
    plan = with_seed(load_plan("clean"), seed)
    if coarse:  # where it matters who does the work, not what comes of it
        plan = msgspec.structs.replace(
            plan,
            pose=msgspec.structs.replace(plan.pose, rate=5.0),  # [Hz]
            joypad=msgspec.structs.replace(plan.joypad, rate=20.0),  # [Hz]
        )
    trials = {
        f"S{i}": TrialEntry(kind, seconds) for i, kind in enumerate(("surge", "sway", "yaw"), 1)
    }
    plan = msgspec.structs.replace(plan, trials=trials)
    vehicle = load_vehicle("mallard-mp")
    truth = plant_model(plan, vehicle)
    truth = replace(truth, coefficients=truth.coefficients / heavier)
    write_setting(plan, vehicle, truth, folder)
    for trial in simulate(plan, vehicle, truth):
        write_trial(trial, folder)


@pytest.fixture(scope="module")
def boats(tmp_path_factory):
    """A boat, one with a damaged log, one without a vehicle file."""
    root = tmp_path_factory.mktemp("fleet") / "boats"
    boat(root / "ada", 1)
    boat(root / "bea", 2)
    (root / "bea" / "torn.bag").write_bytes(b"#ROSBAG V2.0\n" + b"\0" * 50)
    (root / "cid").mkdir()
    (root / "cid" / "run.csv").write_text("t,x\n0,1\n")
    return root


@pytest.fixture(scope="module")
def ran(boats, tmp_path_factory):
    """The fleet after one run in this process; `FIRST` beside it stays as that run wrote it."""
    out = tmp_path_factory.mktemp("ran") / "out"
    result = fleet(load_fleet(boats), out).result
    shutil.copytree(out, out.with_name(FIRST))
    return out, result


def rows(result: FleetResult):
    return {one.result.name: one for one in result.boats}


def test_every_boat_has_its_row_and_what_fails_is_in_it(ran):
    _, result = ran
    found = rows(result)
    assert list(found) == ["ada", "bea", "cid"]
    assert result.failed == ["cid"]
    assert "no vehicle.yaml" in found["cid"].result.error
    assert all(ratio < 0.1 for ratio in found["ada"].result.ratios.values())
    # the damaged log is left out, its boat is not
    bea = {r.name: r for r in found["bea"].result.recordings}
    assert result.bad_recordings == ["bea/torn"]
    assert "torn.bag" in bea["torn"].error and "\n" not in bea["torn"].error
    assert bea["S1-MP"].error is None and found["bea"].result.error is None
    truth = plant_model(load_plan("clean"), load_vehicle("mallard-mp")).values
    for name in ("X_F", "Y_F", "N_F"):
        for one in ("ada", "bea"):
            assert found[one].result.parameters[name].value == pytest.approx(truth[name], rel=0.05)


def test_reports_are_linked_and_written(ran):
    out, result = ran
    page = (out / "fleet.html").read_text()
    assert 'href="boats/ada/report.html"' in page
    assert (out / "boats/ada/report.html").is_file()
    assert rows(result)["cid"].report is None
    assert json.loads((out / "fleet.json").read_text())["failed"] == ["cid"]


def test_a_second_run_does_only_what_is_new(ran, boats, monkeypatch):
    out, result = ran
    done = []
    real = fleet.__globals__["work_on_boat"].__globals__["_identified"]
    monkeypatch.setitem(
        fleet.__globals__["work_on_boat"].__globals__, "_identified",
        lambda one, *more: done.append(one.name) or real(one, *more),
    )  # fmt: skip
    assert fleet(load_fleet(boats), out).result == result
    assert done == []
    # another file in one boat's folder: that boat again
    note = boats / "ada" / "S9.csv"
    note.write_text("t,x\n0,1\n")
    again = fleet(load_fleet(boats), out).result
    note.unlink()
    assert done == ["ada"]
    assert again.bad_recordings == ["ada/S9", "bea/torn"]


@pytest.mark.system
def test_a_result_that_was_cut_off_is_made_again(ran, boats):
    out, result = ran
    path = out / "boats" / "bea" / "boat.json"
    path.write_text(path.read_text()[:100])
    assert fleet(load_fleet(boats), out).result == result


@pytest.mark.system
def test_the_previous_model_shows_what_changed(ran, tmp_path):
    boat(tmp_path / "may" / "ada", 2, heavier=1.2)
    boat(tmp_path / "june" / "ada", 2)
    first = ran[0].with_name(FIRST)
    found = fleet(load_fleet(tmp_path / "may", first), tmp_path / "may-fleet").result
    assert found.changed == ["ada"]
    assert "mass" in " ".join(rows(found)["ada"].result.change.text)
    same = fleet(load_fleet(tmp_path / "june", first), tmp_path / "june-fleet").result
    assert same.changed == []
    assert rows(same)["ada"].result.change.p > 0.05


def config(path, text):
    path.write_text(text)
    return path


def squared(common, item):
    """Of an item; one on purpose with an error."""
    if item < 0:
        raise FleetError("negative")
    return common + item**2


def test_farmed_work_is_in_order_and_raises_the_first_error(on_cores):
    on_cores(3)
    assert farmed(squared, 1, [3, 2, 1]) == [10, 5, 2]
    with working_on(InTurn()):
        assert farmed(squared, 1, [3, 2, 1]) == [10, 5, 2]
        with pytest.raises(FleetError, match="negative"):
            farmed(squared, 1, [3, -2, 1])
    with on_one_core():
        assert cores() == 1


def test_a_missing_extra_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(FleetError, match=r"pip install 'seatrial\[fleet\]'"), cluster():
        pass


def test_schedulers_that_are_not_there(tmp_path, monkeypatch):
    monkeypatch.setattr(dask_cluster, "CONNECT_WITHIN", 0.3)
    for where, words in (
        ("tcp://127.0.0.1:9", "no scheduler with a worker answers"),
        (str(tmp_path / "none.json"), "there is no such file"),
        (str(config(tmp_path / "s.json", "{}")), "no address of a scheduler"),
    ):
        with pytest.raises(FleetError, match=words), cluster(where):
            pass


def same_files(one, other):
    """Names of files that differ."""
    names = {p.relative_to(one) for p in one.rglob("*") if p.is_file()}
    assert names == {p.relative_to(other) for p in other.rglob("*") if p.is_file()}
    return [str(n) for n in names if (one / n).read_bytes() != (other / n).read_bytes()]


@pytest.mark.system
@pytest.mark.filterwarnings("ignore")  # of Dask's own threads and sockets at the end
def test_two_workers_write_the_same_bytes_as_this_process(ran, boats, tmp_path):
    with cluster(workers=2) as farm:
        assert [*farmed_by(farm, [1, 2, 3])] == [2, 5, 10]
        fleet(load_fleet(boats), tmp_path / "out", farm)
    assert same_files(ran[0].with_name(FIRST), tmp_path / "out") == []


def farmed_by(farm, items):
    with working_on(farm):
        return farmed(squared, 1, items)


@pytest.mark.system
@pytest.mark.filterwarnings("ignore")  # of Dask's own threads and sockets at the end
def test_the_bootstrap_does_not_depend_on_workers(boats, tmp_path, capsys):
    ada = [boats / "ada" / f"S{i}-MP" for i in (1, 2, 3)]
    given = ["identify", *ada, "--vehicle", boats / "ada" / "vehicle-MP.yaml", "-o", tmp_path / "m.yaml",
             "--bootstrap", 40]  # fmt: skip
    here = done(capsys, *given)
    there = done(capsys, *given, "--scheduler", "local", "--workers", 1)
    assert there == here


@pytest.mark.system
@pytest.mark.filterwarnings("ignore")  # of Dask's own threads and sockets at the end
@pytest.mark.parametrize(
    "command",
    [("select", "--json", "-"), ("identify", "--structure", "auto", "-v", "-o", "m.yaml")],
)
def test_a_selection_does_not_depend_on_workers(tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    boat(tmp_path, 1, seconds=102.0, coarse=True)  # select asks for 100 s
    recordings = [f"S{i}-MP" for i in (1, 2, 3)]
    given = [command[0], *recordings, "--vehicle", "vehicle-MP.yaml", *command[1:]]
    here = done(capsys, *given)
    assert "Y_ur" in here  # a candidate: terms were tried
    there = done(capsys, *given, "--scheduler", "local", "--workers", 2)
    assert there == here


def command_of(*given):
    """`seatrial` in a process of its own."""
    words = [sys.executable, "-m", "seatrial", *map(str, given)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def table_of(out):
    """The fleet's file."""
    return (out / "fleet.json").read_bytes()


def workers_of(process):
    """Process ids of Dask's workers."""
    return [
        child.pid for child in psutil.Process(process.pid).children(recursive=True)
        if any("spawn_main" in word for word in child.cmdline())
    ]  # fmt: skip


@pytest.mark.system
def test_a_killed_worker_loses_nothing(ran, boats, tmp_path):
    out = tmp_path / "out"
    with command_of("fleet", boats, "-o", out, "--workers", 2) as running:
        # a boat is begun: its worker, or the other one, is killed
        until(lambda: list(out.glob("boats/*/vehicle.yaml")), "a boat")
        victims = workers_of(running)
        assert victims
        os.kill(victims[0], signal.SIGKILL)
        _, errors = running.communicate(timeout=240)
    assert running.returncode == 0, errors
    assert "Traceback" not in errors
    assert table_of(out) == table_of(ran[0].with_name(FIRST))


class ByHand:
    """`dask scheduler` and two `dask worker`, each of its own folder, as a user starts them."""

    def __init__(self, root):
        self.file, self._running = root / "scheduler.json", []
        self.scheduler = self._start(root / "s", "scheduler", "--host", "127.0.0.1", "--port", 0)
        for name in ("a", "b"):
            own = ("--nthreads", 1, "--no-nanny", "--local-directory", root / name)
            self._start(root / name, "worker", *own)

    def _start(self, folder, *command):
        folder.mkdir()
        command = (*command, "--scheduler-file", self.file, "--no-dashboard")
        words = [sys.executable, "-m", "dask", *map(str, command)]
        with (folder / "log").open("w") as log:
            self._running.append(
                subprocess.Popen(words, cwd=folder, stdout=log, stderr=log, start_new_session=True)
            )
        return self._running[-1]

    def stop(self):
        for one in reversed(self._running):
            one.terminate()
        for one in self._running:
            one.wait(PATIENCE)


@pytest.fixture
def by_hand(tmp_path):
    (tmp_path / "cluster").mkdir()
    started = ByHand(tmp_path / "cluster")
    yield started
    started.stop()


@pytest.mark.system
@pytest.mark.filterwarnings("ignore")  # of Dask's own threads and sockets at the end
def test_a_scheduler_elsewhere_makes_the_same_table_and_says_when_it_ends(
    ran, boats, tmp_path, by_hand, capsys
):
    until(by_hand.file.exists, "the scheduler")
    out = tmp_path / "out"
    with command_of("fleet", boats, "-o", out, "--scheduler", by_hand.file) as running:
        _, errors = running.communicate(timeout=240)
    assert running.returncode == 0, errors
    assert table_of(out) == table_of(ran[0].with_name(FIRST))
    # a recording that is not where the fleet's file says
    gone = config(
        tmp_path / "gone.yaml", "seatrial: fleet 1\nboats: {ada: {vehicle: "
        f"{boats}/ada/vehicle-MP.yaml, recordings: [{tmp_path}/none.bag]}}}}\n",
    )  # fmt: skip
    code, _, errors = run(
        capsys, "fleet", gone, "-o", tmp_path / "gone", "--scheduler", by_hand.file
    )
    assert code == 0, errors
    said = f"none.bag: no such file or folder on {node()}"
    assert said in (tmp_path / "gone" / "fleet.json").read_text()
    # the scheduler ends while boats are worked on
    later = tmp_path / "later"
    with command_of("fleet", boats, "-o", later, "--scheduler", by_hand.file) as running:
        until(lambda: list(later.glob("boats/*/vehicle.yaml")), "a boat")
        by_hand.scheduler.kill()
        _, errors = running.communicate(timeout=240)
    assert running.returncode == 1, errors
    assert "the scheduler has ended" in errors and "Traceback" not in errors
