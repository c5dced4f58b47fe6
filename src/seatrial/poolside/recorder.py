# SPDX-License-Identifier: MIT
"""The recording of a session: tables that only grow, on the disk within a second.

A row is in the system's memory when `use` returns, so a killed program loses none; a thread writes it to
the disk within `SYNC`, so a power cut loses a second.

    FOLDER/poses.csv, or positions.csv and headings.csv; commands.csv, scales.csv
    FOLDER/kept_*.csv    poses without the discarded intervals, from the first of these on
    FOLDER/notes.jsonl   marks and discarded intervals
    FOLDER/vehicle.yaml  the vehicle, with the columns of these tables
"""

import errno
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from threading import Event, Lock, Thread

import msgspec
import numpy as np

from seatrial.boat.schema import Column, PoseSource
from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.sources.source import EventKind
from seatrial.util.errors import FileError
from seatrial.util.files import dump_yaml, sync_folder, writable, write_text
from seatrial.util.frames import NS_PER_S, Array

SYNC = 0.5  # [s] between two writes to the disk
SECONDS, NANOSECONDS = "stamp [s]", "stamp [ns]"  # no name of an input ends so
STAMP = Column(column=SECONDS, nanoseconds=NANOSECONDS)
FILES: dict[EventKind, str] = {
    "pose": "poses.csv", "position": "positions.csv", "heading": "headings.csv", "command": "commands.csv",
    "scale": "scales.csv",
}  # fmt: skip
POSE_KINDS: tuple[EventKind, ...] = ("pose", "position", "heading")
NOTES, VEHICLE = "notes.jsonl", "vehicle.yaml"
KEPT = "kept_"  # begins the name of a table without the discarded intervals


class Note(msgspec.Struct, frozen=True, omit_defaults=True):
    """A mark, or an interval that is discarded."""

    stamp: int  # [ns]
    mark: str | None = None
    discard_from: int | None = None  # [ns] to `stamp`


class Recorder:
    """Writes events to a new folder. Methods may be called from any thread; they raise FileError."""

    def __init__(self, folder: Path, vehicle: Vehicle) -> None:
        self.folder, self._original = folder, vehicle
        self._flip = vehicle.axes.signs
        self._names: dict[EventKind, tuple[str, ...]] = {
            "pose": ("x", "y", "psi"), "position": ("x", "y"), "heading": ("psi",),
            "command": vehicle.inputs, "scale": vehicle.scales,
        }  # fmt: skip
        self._signs: dict[EventKind, Array] = {
            "pose": self._flip, "position": self._flip[:2], "heading": self._flip[2:],
            "command": vehicle.input_signs, "scale": np.ones(len(vehicle.scales)),
        }  # fmt: skip
        self._heads = {k: ",".join([SECONDS, NANOSECONDS, *n]) for k, n in self._names.items()}
        self._handles: dict[str, int] = {}
        self._lost = ""  # that the folder is not there any more
        self._lock, self._ended, self._changed = Lock(), Event(), False
        self._rewriting = Lock()  # of tables without the discarded intervals, one after the other
        self.notes: list[Note] = []
        self._discarded: tuple[tuple[int, int], ...] = ()
        self._make()
        self._thread = Thread(target=self._sync, name="recorder", daemon=True)
        self._thread.start()

    def use(self, kind: EventKind, stamp: int, values: Array) -> None:
        """A row; values forward-left-up, of poses those of the measured point.

        Raises FileError, too, where the folder is not there any more.
        """
        own = (values * self._signs[kind]).tolist()
        seconds, rest = divmod(stamp, NS_PER_S)
        line = ",".join([str(seconds), str(rest), *map(repr, own)])
        with self._lock:
            if kind == "position" and FILES["position"] not in self._handles:
                self._write_vehicle(split=True)
            head = self._heads[kind]
            self._append(FILES[kind], line, head)
            if self._discarded and kind in POSE_KINDS and not self._is_discarded(line.encode()):
                self._append(KEPT + FILES[kind], line, head)
            if self._lost:
                raise FileError(self._lost)

    def mark(self, stamp: int, text: str) -> None:
        """Mark a moment [ns]."""
        self._note(Note(stamp, mark=text))

    def discard(self, start: int, end: int) -> None:
        """Leave poses from `start` to `end` [ns] out of the recording; the first tables keep them.

        The vehicle file then reads the tables without them, so that they stay out whatever ends the program.
        """
        with self._rewriting:
            self._note(Note(end, discard_from=start))
            with self._lock:
                self._discarded = (*self._discarded, (start, end))
                names = [FILES[kind] for kind in POSE_KINDS if FILES[kind] in self._handles]
            for name in names:
                self._write_kept(name)
            with self._lock:
                self._write_vehicle(split=FILES["position"] in self._handles)

    @property
    def discarded(self) -> tuple[tuple[int, int], ...]:
        """Intervals [ns] that are left out."""
        return self._discarded

    def finish(self) -> Path:
        """Write all to the disk, and end; the folder. Raises FileError where it is not there any more."""
        self.close()
        self._look()
        if self._lost:
            raise FileError(self._lost)
        return self.folder

    def close(self) -> None:
        """End; what was written stays. Without effect where it has ended."""
        self._ended.set()
        self._thread.join()
        with self._rewriting, self._lock:
            for handle in self._handles.values():
                os.close(handle)
            self._handles = {}

    def _make(self) -> None:
        """The folder, which must not hold anything."""
        with writable(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)
            if any(self.folder.iterdir()):
                raise FileError(
                    f"{self.folder}: is not empty, and a recording is never overwritten; give another folder"
                )
        self._write_vehicle(split=False)

    def _write_vehicle(self, *, split: bool) -> None:
        """The vehicle file that reads the folder; `split`: position and heading have tables of their own."""
        prefix = KEPT if self._discarded else ""
        self.vehicle = _with_tables(self._original, split=split, prefix=prefix)
        write_text(self.folder / VEHICLE, dump_yaml(self.vehicle.to_mapping()))

    def _note(self, note: Note) -> None:
        with self._lock:
            self._append(NOTES, msgspec.json.encode(note).decode())
            self.notes.append(note)

    def _append(self, name: str, line: str, header: str = "") -> None:
        """A whole line by one call of the system."""
        try:
            if name not in self._handles:
                if self._ended.is_set():
                    raise FileError(f"{self.folder / name}: the recording has ended")
                flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND
                self._handles[name] = os.open(self.folder / name, flags, 0o666)
                line = f"{header}\n{line}" if header else line
            _write_whole(self._handles[name], f"{line}\n".encode())
        except OSError as error:
            path = self.folder / name
            raise FileError(f"{path}: can't be written ({error.strerror})") from None
        self._changed = True

    def _sync(self) -> None:
        """Write what has changed to the disk, every `SYNC`."""
        ended = False
        while not ended:
            ended = self._ended.wait(SYNC)
            with self._lock:
                handles, changed = [os.dup(h) for h in self._handles.values()], self._changed
                self._changed = False
            for handle in handles:
                with suppress(OSError):  # a full disk is reported by the next row
                    if changed:
                        os.fsync(handle)
                os.close(handle)
            if changed:
                sync_folder(self.folder)
            self._look()

    def _look(self) -> None:
        """Whether the tables are still in the folder, where others find them."""
        with self._lock:
            names = [*self._handles, VEHICLE]
        missing = [name for name in names if not (self.folder / name).exists()]
        self._lost = (
            f"{self.folder}: {', '.join(missing)} is not there any more: removed, or renamed. Rows since then "
            "are lost when the session ends. Put the folder back, or stop and begin anew"
            if missing else ""
        )  # fmt: skip

    def _write_kept(self, name: str) -> None:
        """The table without the rows in discarded intervals, to which further rows are added.

        Rows go on arriving meanwhile: only those are written under the lock.
        """
        table, kept = self.folder / name, self.folder / f"{KEPT}{name}"
        part = kept.with_suffix(".part")
        try:
            with table.open("rb") as rows, part.open("wb") as file:
                with self._lock:
                    size = os.fstat(self._handles[name]).st_size
                file.writelines(self._kept(rows.read(size)))
                file.flush()
                os.fsync(file.fileno())
                with self._lock:
                    file.writelines(self._kept(rows.read()))
                    file.close()
                    self._put_in_place(part, kept)
        except OSError as error:
            raise FileError(f"{kept}: can't be written ({error.strerror})") from None
        finally:
            part.unlink(missing_ok=True)

    def _put_in_place(self, part: Path, kept: Path) -> None:
        """Rows are added to the new file from now on."""
        before = self._handles.pop(kept.name, None)
        if before is not None:
            os.close(before)
        part.replace(kept)
        self._handles[kept.name] = os.open(kept, os.O_WRONLY | os.O_APPEND)
        self._changed = True

    def _kept(self, table: bytes) -> Iterator[bytes]:
        """Lines of a table that are in no discarded interval."""
        return (row for row in table.splitlines(keepends=True) if not self._is_discarded(row))

    def _is_discarded(self, row: bytes) -> bool:
        seconds, rest, _ = row.split(b",", 2)
        if not rest.isdigit():  # the header
            return False
        stamp = int(seconds) * NS_PER_S + int(rest)
        return any(start <= stamp <= end for start, end in self._discarded)


def _write_whole(handle: int, line: bytes) -> None:
    """Add a line, or nothing: where the disk is full, part of it would spoil the next one. Raises OSError."""
    written = os.write(handle, line)
    if written < len(line):
        os.ftruncate(handle, os.fstat(handle).st_size - written)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _with_tables(vehicle: Vehicle, *, split: bool, prefix: str = "") -> Vehicle:
    """The vehicle with the columns of the recorder's tables. split: position and heading have their own."""
    file, spec = vehicle.file, vehicle.file.pose
    place = FILES["position" if split else "pose"]
    heading = Column(column="psi", file=prefix + FILES["heading"]) if split else "psi"
    pose = PoseSource(
        stamp=STAMP, x="x", y="y", psi=heading, file=prefix + place,
        lever=spec.lever, delay=spec.delay, heading_delay=spec.heading_delay,
    )  # fmt: skip
    commands = msgspec.structs.replace(
        file.commands, inputs={name: name for name in vehicle.inputs}, stamp=STAMP,
        file=FILES["command"], topic=None, clock="header",
    )  # fmt: skip
    scales = {
        name: msgspec.structs.replace(one, column=Column(column=name, file=FILES["scale"]))
        for name, one in file.scales.items()
    }
    changed = msgspec.structs.replace(file, pose=pose, commands=commands, scales=scales)
    return Vehicle(changed, vehicle.source)
