# SPDX-License-Identifier: MIT
"""Many boats at once: the same table whoever did the work, what fails in its row, nothing done twice."""

import json
import os
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from platform import node

import msgspec
import numpy as np
import psutil
import pytest
from cli_tools import run
from waiting import PATIENCE, until

from seatrial.boat.vehicle import load_vehicle
from seatrial.fleet import dask_cluster
from seatrial.fleet.dask_cluster import cluster
from seatrial.fleet.fleet import fleet
from seatrial.fleet.fleet_file import load_fleet
from seatrial.fleet.kinds import FEWEST_BOATS, centre_of, compare_kind
from seatrial.fleet.results import BoatResult, Estimate, FleetResult
from seatrial.io.trial_files import write_setting, write_trial
from seatrial.simulation.plan import TrialEntry, load_plan, with_seed
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import FleetError, SeatrialError
from seatrial.util.parallel import InTurn, cores, farmed, on_one_core, working_on

FIRST = "first"
SECONDS = 40.0  # of each recording
EVIL = "<img src=x onerror=alert(1)>"


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


def test_command_prints_the_table_and_refuses_what_it_would_spoil(boats, tmp_path, capsys):
    one = tmp_path / "small"
    one.mkdir()
    (one / "ada").symlink_to(boats / "cid")
    code, text, _ = run(capsys, "fleet", boats, "--workers", 0, "-o", boats / "in", "--json", "-")
    assert code == 1
    code, text, _ = run(capsys, "fleet", one, "--workers", 0, "-o", tmp_path / "out")
    assert code == 0 and "0 of 1 boats have a model" in text
    assert "\nada: run.csv is a link out of the fleet's folder" in text
    for words, wrong in (
        ("no results of a fleet", ("--last-time", tmp_path)),
        ("has the results of last time", ("--last-time", tmp_path / "out")),
    ):
        (tmp_path / "out" / "boats").mkdir(exist_ok=True)
        code, _, error = run(capsys, "fleet", one, "--workers", 0, "-o", tmp_path / "out", *wrong)
        assert code == 1 and words in error


def config(path, text):
    path.write_text(text)
    return path


def test_a_file_names_kinds_vehicles_and_options(boats, tmp_path):
    found = load_fleet(
        config(
            tmp_path / "fleet.yaml",
            f"""\
seatrial: fleet 1
name: harbour
vehicle: mallard-mp
identify: {{effects: [lever]}}
boats:
  zoe:
    kind: heavy
    recordings: [{boats}/ada/S1-MP, {boats}/ada/S2-MP]
    test: S2-MP
  abe: {{recordings: [{boats}/bea/S1-MP], vehicle: {boats}/bea/vehicle-MP.yaml, identify: {{salvage: true}}}}
  ../evil: {{recordings: [x]}}
""",
        )
    )
    assert [one.name for one in found.boats] == ["../evil", "abe", "zoe"]
    evil, abe, zoe = found.boats
    assert "can't be a folder's" in evil.refused
    assert (abe.kind, zoe.kind, zoe.test) == ("harbour", "heavy", "S2-MP")
    assert zoe.options.effects == ("lever",) and abe.options.salvage
    assert zoe.vehicle == Path("mallard-mp") and zoe.recordings[0] == boats / "ada" / "S1-MP"
    result = fleet(found, tmp_path / "out", _Never()).result
    assert set(result.failed) == {"../evil", "abe", "zoe"}
    assert not (tmp_path / "evil").exists() and rows(result)["../evil"].report is None


class _Never(InTurn):
    """Workers without memory."""

    def outcomes(self, work, common, items):
        for place, _ in enumerate(items):
            yield place, MemoryError(EVIL)


def test_a_second_run_in_the_same_folder_is_refused_until_the_first_ends(boats, tmp_path):
    fcntl = pytest.importorskip("fcntl")
    odd = tmp_path / "boats"
    (odd / "ada").mkdir(parents=True)
    (tmp_path / "out").mkdir()
    with (tmp_path / "out" / ".lock").open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(FleetError, match="another 'seatrial fleet' works on this folder"):
            fleet(load_fleet(odd), tmp_path / "out")
    assert fleet(load_fleet(odd), tmp_path / "out").result.failed == ["ada"]
    (tmp_path / "file").touch()
    with pytest.raises(SeatrialError, match="can't be written"):
        fleet(load_fleet(odd), tmp_path / "file" / "out")


class _Elsewhere(InTurn):
    """Workers with a disk of their own."""

    def outcomes(self, work, common, items):
        for place, one in enumerate(items):
            yield place, msgspec.structs.replace(made_up(one.name, 1.0), kind=one.kind)


def test_results_that_stay_on_the_workers_are_no_results(boats, tmp_path):
    result = fleet(load_fleet(boats), tmp_path / "out", _Elsewhere()).result
    assert result.failed == ["ada", "bea", "cid"]
    assert "this computer does not see" in rows(result)["ada"].result.error


def test_names_and_errors_are_escaped_in_the_page(boats, tmp_path):
    odd = tmp_path / "boats"
    (odd / EVIL).mkdir(parents=True)
    fleet(load_fleet(odd), tmp_path / "out")
    assert EVIL not in (tmp_path / "out" / "fleet.html").read_text()
    fleet(load_fleet(boats), tmp_path / "out2", _Never())
    page = (tmp_path / "out2" / "fleet.html").read_text()
    assert EVIL not in page and "seatrial failed: MemoryError: &lt;img" in page


def test_links_out_of_the_folder_are_refused(boats, tmp_path):
    (tmp_path / "fleet" / "eve").mkdir(parents=True)
    (tmp_path / "fleet" / "eve" / "S1").symlink_to(boats / "ada" / "S1-MP")
    (tmp_path / "fleet" / "vehicle.yaml").write_text("x")
    (found,) = load_fleet(tmp_path / "fleet").boats
    assert "link out of the fleet's folder" in found.refused


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("seatrial: fleet 1\nboats: {}\n", "no boats"),
        ("seatrial: fleet 2\nboats: {}\n", "expected 'seatrial: fleet 1'"),
        ("seatrial: fleet 1\nboats: {a: {recordings: [x], vehicel: y}}\n", "vehicel"),
        ("seatrial: fleet 1\nidentify: {effects: [fish]}\nboats: {a: {recordings: [x]}}\n", "fish"),
    ],
)
def test_a_wrong_file_is_one_line(tmp_path, text, words):
    with pytest.raises(SeatrialError, match=words):
        load_fleet(config(tmp_path / "fleet.yaml", text))


def made_up(name, value, error=0.01, structure="s"):
    one = {"X_F": Estimate(value, error, "m/s^2")}
    return BoatResult(name, "k", "", None, [], structure, one, {}, [], None)


def test_an_odd_boat_differs_from_its_kind_and_does_not_move_it():
    rng = np.random.default_rng(4)
    values = 1.0 + 0.05 * rng.normal(size=20)
    values[7] = 2.0
    found = compare_kind([made_up(f"b{i}", float(v)) for i, v in enumerate(values)])
    assert list(found.differs) == ["b7"]
    (one,) = found.differs["b7"]
    assert one.centre == pytest.approx(1.0, abs=0.03) and one.z > 10
    assert found.kind.parameters["X_F"].between == pytest.approx(
        np.delete(values, 7).std(), rel=0.3
    )


def test_errors_alone_leave_nothing_between_boats():
    rng = np.random.default_rng(2)
    between = [
        centre_of(1.0 + 0.1 * rng.normal(size=30), np.full(30, 0.1)).between for _ in range(40)
    ]
    assert np.median(between) < 0.04


def test_boats_of_a_kind_are_seldom_called_different():
    rng = np.random.default_rng(1)
    alarms = 0
    for _ in range(200):
        errors = rng.uniform(0.01, 0.1, size=12)
        values = 1.0 + np.hypot(errors, 0.05) * rng.normal(size=12)
        one = [
            made_up(f"b{i}", float(v), float(e))
            for i, (v, e) in enumerate(zip(values, errors, strict=True))
        ]
        alarms += bool(compare_kind(one).differs)
    assert alarms <= 18  # 10 expected at 5 %; binomial 99 %


def test_few_boats_and_another_structure_are_not_compared():
    few = compare_kind([made_up(f"b{i}", 1.0) for i in range(FEWEST_BOATS - 1)])
    assert not few.kind.parameters and all(
        "or more can be compared" in w for w in few.not_compared.values()
    )
    more = [made_up(f"b{i}", 1.0) for i in range(FEWEST_BOATS)]
    odd = compare_kind([*more, made_up("odd", 1.0, structure="other")])
    assert list(odd.not_compared) == ["odd"] and odd.kind.compared == FEWEST_BOATS


def test_simulated_seeds_are_a_fleet(tmp_path, capsys):
    plan = config(tmp_path / "plan.yaml", "seatrial: plan 1\nbased_on: clean\nname: short\n"
                  "trials: {S1: {drive: surge, duration: 10}}\n")  # fmt: skip
    out = tmp_path / "boats"
    words = ("--vehicle", "mallard-mp", "--seeds", 3, "--seed", 9, "-o", out)
    code, text, _ = run(capsys, "simulate", "--plan", plan, *words)
    assert code == 0 and f"seatrial fleet {out}" in text
    found = load_fleet(out)
    assert [one.name for one in found.boats] == ["seed-09", "seed-10", "seed-11"]
    assert [[r.name for r in one.recordings] for one in found.boats] == [["S1-MP"]] * 3
    paths = {(one.recordings[0] / "poses.csv").read_bytes() for one in found.boats}
    assert len(paths) == 3
    assert run(capsys, "simulate", "--plan", plan, "--seeds", 0, "-o", out)[0] == 1


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
    code, here, _ = run(capsys, *given)
    assert code == 0
    code, there, _ = run(capsys, *given, "--scheduler", "local", "--workers", 1)
    assert code == 0
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
    code, here, _ = run(capsys, *given)
    assert code == 0
    assert "Y_ur" in here  # a candidate: terms were tried
    code, there, _ = run(capsys, *given, "--scheduler", "local", "--workers", 2)
    assert code == 0
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
