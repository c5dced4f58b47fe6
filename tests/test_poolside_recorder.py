# SPDX-License-Identifier: MIT
"""The recorder: what is read back is what arrived, a kill loses nothing that was taken, nothing is overwritten."""

import shutil
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from poolside_sources import VEHICLE, table, vehicle
from waiting import PATIENCE

from seatrial.boat.vehicle import load_vehicle
from seatrial.commands.cli import main
from seatrial.io.reader import read
from seatrial.poolside.recorder import Recorder
from seatrial.poolside.session.saving import save_mcap
from seatrial.poolside.sources import open_source
from seatrial.util.errors import FileError
from seatrial.util.frames import NS_PER_S

BEGIN = 1_700_000_000_123_456_789  # [ns]
FRD = "forward-right-down"


def rows(count, step=50_000_000):
    rng = np.random.default_rng(1)
    values = np.cumsum(rng.normal(size=(count, 3)), axis=0) * 1e-3
    return [(BEGIN + i * step, values[i], rng.uniform(-1, 1, 3)) for i in range(count)]


def use(recorder, given):
    """Each command, and the pose after it."""
    for stamp, pose, command in given:
        recorder.use("command", stamp, command)
        recorder.use("pose", stamp, pose)


@pytest.mark.parametrize("axes", ["forward-left-up", FRD])
def test_what_is_read_back_is_what_arrived_bit_by_bit(tmp_path, axes):
    boat = vehicle(axes=axes, pose={**VEHICLE["pose"], "lever": [0.1, 0.2]})
    recorder = Recorder(tmp_path / "drive", boat)
    given = rows(100)
    use(recorder, given)
    folder = recorder.finish()
    own = load_vehicle(folder / "vehicle.yaml")
    assert own.lever == boat.lever
    assert own.to_mapping()["structure"] == boat.to_mapping()["structure"]
    recording = read(folder, own)
    assert recording.stamps.tolist() == [stamp for stamp, _, _ in given]
    np.testing.assert_array_equal(recording.commands.values, [c for _, _, c in given])
    np.testing.assert_array_equal(recording.commands.stamps, recording.stamps)
    ahead, left = boat.lever
    c, s = np.cos(recording.eta[:, 2]), np.sin(recording.eta[:, 2])
    measured = recording.eta[:, :2] + np.column_stack([c * ahead - s * left, s * ahead + c * left])
    np.testing.assert_allclose(measured, [p[:2] for _, p, _ in given], atol=1e-15)


def test_position_and_heading_of_two_sensors_and_scales(tmp_path):
    boat = vehicle(
        scales={"volts": {"column": "v", "reference": 12.0}}, chain=[{"scale": {"signal": "volts"}}]
    )
    recorder = Recorder(tmp_path / "drive", boat)
    for stamp, pose, command in rows(100):
        recorder.use("command", stamp, command)
        recorder.use("scale", stamp, np.array([11.9]))
        recorder.use("position", stamp, pose[:2])
        recorder.use("heading", stamp + 3_000_000, pose[2:])
    folder = recorder.finish()
    recording = read(folder, load_vehicle(folder / "vehicle.yaml"))
    np.testing.assert_array_equal(recording.eta[:, :2], [p[:2] for _, p, _ in rows(100)])
    assert recording.scales is not None
    assert set(recording.scales.values.ravel()) == {11.9}
    assert not (folder / "poses.csv").exists()


def test_discarded_intervals_are_left_out_of_the_saved_recording_and_stay_in_the_raw_one(tmp_path):
    recorder = Recorder(tmp_path / "drive", vehicle())
    given = rows(200)
    use(recorder, given)
    recorder.mark(given[20][0], 'begin "zigzag"\n')
    recorder.discard(given[50][0], given[59][0])
    recorder.discard(given[195][0], given[199][0])
    folder = recorder.finish()
    recording = read(folder, load_vehicle(folder / "vehicle.yaml"))
    kept = [stamp for i, (stamp, _, _) in enumerate(given) if not (50 <= i <= 59 or i >= 195)]
    assert recording.stamps.tolist() == kept
    assert len(recording.commands.stamps) == 200
    assert len((folder / "poses.csv").read_text().splitlines()) == 201
    notes = (folder / "notes.jsonl").read_text().splitlines()
    assert len(notes) == 3
    assert '"mark":"begin \\"zigzag\\"\\n"' in notes[0]
    assert recorder.discarded == ((given[50][0], given[59][0]), (given[195][0], given[199][0]))


def test_a_killed_program_leaves_discarded_rows_out(tmp_path):
    recorder = Recorder(tmp_path / "drive", vehicle())
    given = rows(200)
    for i, (stamp, pose, command) in enumerate(given):
        recorder.use("command", stamp, command)
        recorder.use("pose", stamp, pose)
        if i in (59, 120):
            recorder.discard(given[i - 9][0], stamp)
            late = given[i - 5]
            recorder.use("pose", late[0] + 1, late[1])  # inside: left out, too
    folder = tmp_path / "drive"  # as it is, without an end
    recording = read(folder, load_vehicle(folder / "vehicle.yaml"))
    kept = [
        stamp for i, (stamp, _, _) in enumerate(given) if not (50 <= i <= 59 or 111 <= i <= 120)
    ]
    assert recording.stamps.tolist() == kept
    assert len((folder / "poses.csv").read_text().splitlines()) == 203
    before = (folder / "kept_poses.csv").read_bytes()
    recorder.finish()
    assert (folder / "kept_poses.csv").read_bytes() == before


def test_rows_go_on_arriving_while_discarded_ones_are_taken_out(tmp_path, monkeypatch):
    """The disk is slow: nothing waits for it, and a kill at that moment loses none."""
    given, folder = rows(100), tmp_path / "drive"
    recorder = Recorder(folder, vehicle())
    use(recorder, given[:50])
    more, killed, discards = iter(given[50:]), [], []

    def slow(_):
        if threading.current_thread() is threading.main_thread() and len(killed) < len(discards):
            other = threading.Thread(target=lambda: recorder.use("pose", *next(more)[:2]))
            other.start()
            other.join(PATIENCE)
            assert not other.is_alive()
            killed.append(shutil.copytree(folder, tmp_path / f"killed-{len(killed)}"))

    monkeypatch.setattr("seatrial.poolside.recorder.os.fsync", slow)
    for i in (30, 40):
        discards.append((given[i][0], given[i + 4][0]))
        recorder.discard(*discards[-1])
    recorder.finish()

    def stamps(place):
        return read(place, load_vehicle(place / "vehicle.yaml")).stamps.tolist()

    every = [stamp for stamp, _, _ in given[:52]]
    first, second = (set(every[i : i + 5]) for i in (30, 40))
    assert stamps(killed[0]) == every[:51]
    assert stamps(killed[1]) == [stamp for stamp in every if stamp not in first]
    assert stamps(folder) == [stamp for stamp in every if stamp not in first | second]
    assert not [*folder.glob("*.part")]


def test_a_full_disk_leaves_no_half_row(tmp_path):
    """A file that may not grow further takes the beginning of a row: the rows after it must not join it."""
    resource = pytest.importorskip("resource")
    recorder, given = Recorder(tmp_path / "drive", vehicle()), rows(12)
    use(recorder, given[:10])
    table = tmp_path / "drive" / "poses.csv"
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (table.stat().st_size + 10, limits[1]))
    try:
        with pytest.raises(FileError, match="can't be written"):
            recorder.use("pose", *given[10][:2])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    recorder.use("pose", *given[11][:2])
    recorder.discard(given[2][0], given[3][0])
    folder = recorder.finish()
    kept = read(folder, load_vehicle(folder / "vehicle.yaml"))
    assert kept.stamps.tolist() == [given[i][0] for i in (0, 1, 4, 5, 6, 7, 8, 9, 11)]


@pytest.mark.parametrize("how", ["removed", "renamed"])
def test_a_folder_that_is_gone_is_stated(tmp_path, how):
    folder, elsewhere = tmp_path / "drive", tmp_path / "elsewhere"
    recorder = Recorder(folder, vehicle())
    given = rows(3)
    recorder.use("pose", given[0][0], given[0][1])
    written = 2  # with the row that raises
    folder.rename(elsewhere)
    if how == "removed":
        shutil.rmtree(elsewhere)
    with pytest.raises(
        FileError, match=r"poses.csv, vehicle.yaml is not there any more.*begin anew"
    ):
        for _ in range(1200):  # until it looks again, long after on a busy machine
            recorder.use("pose", given[1][0], given[1][1])
            written += 1
            time.sleep(0.1)
    with pytest.raises(FileError, match="not there any more"):
        recorder.finish()
    if how == "renamed":
        elsewhere.rename(folder)
        assert recorder.finish() == folder
        assert len((folder / "poses.csv").read_text().splitlines()) == written + 1


def test_the_recording_is_an_mcap_by_wish(tmp_path):
    recorder = Recorder(tmp_path / "drive" / "recording", vehicle())
    given = rows(100)
    use(recorder, given)
    recorder.discard(given[50][0], given[59][0])
    folder = recorder.finish()
    assert save_mcap(folder, folder.parent) == {"mcap": str(folder.parent / "recording.mcap")}
    kept = read(folder, load_vehicle(folder / "vehicle.yaml"))
    bag = read(folder.parent / "recording.mcap", load_vehicle(folder.parent / "recording.yaml"))
    assert len(kept.stamps) == 90
    np.testing.assert_array_equal(bag.stamps, kept.stamps)
    np.testing.assert_array_equal(bag.raw, kept.raw)
    np.testing.assert_array_equal(bag.commands.values, kept.commands.values)


def test_an_existing_recording_is_never_overwritten(tmp_path):
    first = Recorder(tmp_path / "drive", vehicle())
    first.use("pose", BEGIN, np.zeros(3))
    first.close()
    first.close()
    before = {p: p.read_bytes() for p in (tmp_path / "drive").iterdir()}
    with pytest.raises(FileError, match="never overwritten"):
        Recorder(tmp_path / "drive", vehicle())
    with pytest.raises(FileError, match="has ended"):
        first.use("command", BEGIN, np.zeros(3))
    assert {p: p.read_bytes() for p in (tmp_path / "drive").iterdir()} == before
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="can't be written"):
        Recorder(tmp_path / "file" / "drive", vehicle())


def test_a_full_disk_is_an_error_of_the_row():
    import os

    from seatrial.poolside import recorder as module

    recorder = module.Recorder.__new__(module.Recorder)
    recorder.folder, recorder._handles = (
        module.Path("/dev"),
        {"full": os.open("/dev/full", os.O_WRONLY)},
    )
    with pytest.raises(FileError, match="can't be written"):
        recorder._append("full", "1,2,3")
    os.close(recorder._handles["full"])


DRIVE = """
import sys, time
import numpy as np
from pathlib import Path
from seatrial.boat.vehicle import load_vehicle
from seatrial.poolside.recorder import Recorder
recorder = Recorder(Path(sys.argv[2]), load_vehicle(sys.argv[1]))
i = 0
while True:
    stamp = 1700000000000000000 + 10_000_000 * i
    t = 0.01 * i
    recorder.use("command", stamp, np.array([np.sin(t), np.cos(3 * t), 0.1]))
    recorder.use("pose", stamp, np.array([np.sin(0.3 * t), np.cos(0.3 * t), 0.1 * t]))
    i += 1
    print(i, flush=True)
    time.sleep(0.001)
"""


def test_a_killed_process_leaves_a_recording_that_inspect_opens(tmp_path, capsys):
    import json

    (tmp_path / "vehicle.yaml").write_text(json.dumps(VEHICLE))
    folder = tmp_path / "drive"
    with subprocess.Popen(
        [sys.executable, "-c", DRIVE, str(tmp_path / "vehicle.yaml"), str(folder)],
        stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        last = 0
        for line in process.stdout:
            last = int(line)
            if last >= 500:
                break
        process.send_signal(signal.SIGKILL)
        last = max([last, *(int(text) for text in process.stdout.read().split())])
    for name in ("poses.csv", "commands.csv"):
        head, *lines = (folder / name).read_text().splitlines()
        assert len(lines) >= last
        assert all(line.count(",") == head.count(",") for line in lines)
    recording = read(folder, load_vehicle(folder / "vehicle.yaml"))
    assert (
        recording.stamps[-1] >= 1_700_000_000 * NS_PER_S + 10_000_000 * last - 50_000_000
    )  # dense poses are averaged
    main(["inspect", str(folder), "--vehicle", str(folder / "vehicle.yaml")])
    assert "poses" in capsys.readouterr().out


class Beat:
    """An `Event` whose `wait` ends when the test says so; it keeps for how long [s] was to be waited."""

    def __init__(self) -> None:
        self.asked: list[float] = []
        self._waits, self._go, self._ended = threading.Semaphore(0), threading.Semaphore(0), False

    def wait(self, seconds: float) -> bool:
        self.asked.append(seconds)
        self._waits.release()
        self._go.acquire()
        return self._ended

    def once(self) -> None:
        """Let one wait end; back when the next one begins."""
        self._go.release()
        self._waits.acquire()

    def is_set(self) -> bool:
        return self._ended

    def set(self) -> None:
        self._ended = True
        self._go.release()


def test_the_disk_has_a_row_within_a_second(tmp_path, monkeypatch):
    synced: list[int] = []
    monkeypatch.setattr("seatrial.poolside.recorder.os.fsync", synced.append)
    monkeypatch.setattr("seatrial.poolside.recorder.Event", Beat)
    recorder = Recorder(tmp_path / "drive", vehicle())
    beat = recorder._ended
    beat._waits.acquire()  # until the thread waits
    beat.once()
    synced.clear()
    recorder.use("pose", BEGIN, np.zeros(3))
    beat.once()
    assert len(synced) == 2  # the table, its folder
    beat.once()
    assert len(synced) == 2  # not again without a row
    assert max(beat.asked) <= 1.0
    recorder.close()


def test_a_replay_that_is_recorded_reads_as_its_log(tmp_path):
    table(tmp_path / "run.csv")
    boat = vehicle(axes=FRD)
    recorder = Recorder(tmp_path / "drive", boat)
    for event in open_source(str(tmp_path / "run.csv"), boat, 0.0):
        recorder.use(event.kind, event.stamp, event.values)
    folder = recorder.finish()
    before, after = read(tmp_path / "run.csv", boat), read(folder, recorder.vehicle)
    np.testing.assert_array_equal(before.eta, after.eta)
    np.testing.assert_array_equal(before.stamps, after.stamps)
    np.testing.assert_array_equal(before.commands.values, after.commands.values)
