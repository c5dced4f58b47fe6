# SPDX-License-Identifier: MIT
"""Kind of the bag at a path, and opening it."""

import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from seatrial.io.bags.bag import Bag, Message, merged_topics
from seatrial.io.bags.ros1 import Ros1Bag
from seatrial.io.bags.ros2 import (
    METADATA,
    SUFFIXES,
    Ros2Bag,
    by_number,
    storage_files,
    unusable_metadata,
)
from seatrial.io.bags.salvage_db3 import SalvagedDb3
from seatrial.io.bags.salvage_mcap import SalvagedMcap
from seatrial.io.bags.unpack import UnpackedBag
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.files import readable

ROS1 = (".bag", ".bag.active")  # the second is an unclosed file of rosbag record


class SplitBag(Bag):
    """One recording in several files, read in sequence."""

    def __init__(self, path: Path, parts: Sequence[Bag]) -> None:
        self.path, self.parts = path, tuple(parts)
        self.kind = f"{parts[0].kind} in {len(parts)} files"
        self.files = tuple(f for part in parts for f in part.files)
        self.remarks = tuple(f"{p.path.name}: {r}" for p in parts for r in p.remarks)
        stated = all(len(part.spans) == 1 for part in parts)
        self.spans = tuple(span for part in parts for span in part.spans) if stated else ()
        self.topics = merged_topics([t for part in parts for t in part.topics.values()])

    def close(self) -> None:
        """Close the files."""
        for part in self.parts:
            part.close()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, file by file."""
        for part in self.parts:
            yield from part.messages(names)


def is_bag(path: Path) -> bool:
    """Whether a path is to be read as a bag rather than as tables."""
    if path.is_dir():
        return (path / METADATA).exists() or bool(_storage(path)) or bool(_ros1_files(path))
    return path.name.endswith((*ROS1, *SUFFIXES, ".zstd"))


def open_bag(path: Path, *, salvage: bool = False) -> Bag:
    """A bag, opened; with `salvage` the readable part of a damaged one. Raises RecordingError."""
    if not path.exists():
        raise FileError(f"{path}: no such file or folder")
    with readable(path, RecordingError):
        bag = (_open_folder if path.is_dir() else _open_file)(path, salvage=salvage)
    bag.salvage = salvage
    return bag


def _open_folder(path: Path, *, salvage: bool) -> Bag:
    unusable = unusable_metadata(path) if (path / METADATA).exists() else ""
    if (path / METADATA).exists() and not unusable:
        try:
            return _checked(path) if salvage else Ros2Bag(path)
        except RecordingError:
            if not salvage:
                raise
    files = _storage(path) or _ros1_files(path)
    if not files:
        raise RecordingError(f"{path}: {METADATA} exists, but no .mcap or .db3 next to it")
    parts: list[Bag] = []
    try:
        for file in files:
            parts.append(_open_file(file, salvage=salvage))
    except RecordingError:
        for part in parts:
            part.close()
        raise
    bag = parts[0] if len(parts) == 1 else SplitBag(path, parts)
    if unusable:
        read = f"{METADATA} {unusable}: {len(files)} {'file is' if len(files) == 1 else 'files are'} read without"
        bag.remarks = (*bag.remarks, f"{read} it")
    return bag


def _open_file(path: Path, *, salvage: bool) -> Bag:
    if path.name.endswith(ROS1):
        return Ros1Bag(path, salvage=salvage)
    folder = path.parent
    described = (folder / METADATA).exists() and storage_files(folder) == (path,)
    if described and not salvage and not unusable_metadata(folder):
        return Ros2Bag(folder)  # its metadata state the compression
    if path.suffix == ".zstd":
        return UnpackedBag(path, lambda file: _open_file(file, salvage=salvage), salvage=salvage)
    if path.suffix not in SUFFIXES:
        raise RecordingError(f"{path}: expected a .mcap or .db3, got '{path.suffix}'")
    if not salvage:
        return Ros2Bag(path)
    try:
        return _checked(path)
    except RecordingError as error:
        if path.stat().st_size == 0:
            raise error from None
    return SalvagedMcap(path) if path.suffix == ".mcap" else SalvagedDb3(path)


def _checked(path: Path) -> Ros2Bag:
    """A bag that can be read to its end. Raises RecordingError."""
    bag = Ros2Bag(path)
    try:
        bag.check_all()
    except RecordingError:
        bag.close()
        raise
    return bag


def _storage(folder: Path) -> list[Path]:
    """Files of a ROS 2 recording without metadata."""
    names = [f"*{suffix}{packed}" for suffix in SUFFIXES for packed in ("", ".zstd")]
    return sorted((p for name in names for p in folder.glob(name)), key=by_number)


def _ros1_files(folder: Path) -> list[Path]:
    """The files of one ROS 1 recording: NAME_0.bag, NAME_1.bag and so on."""
    files = sorted(folder.glob("*.bag"), key=by_number)
    stems = {re.sub(r"_\d+$", "", p.stem) for p in files}
    if len(files) > 1 and len(stems) > 1:
        raise RecordingError(
            f"{folder}: {len(files)} bags of different names; give them one by one "
            f"({', '.join(p.name for p in files[:4])} ...)"
        )
    return files
