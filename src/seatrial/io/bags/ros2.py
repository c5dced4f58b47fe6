# SPDX-License-Identifier: MIT
"""ROS 2 bags through rosbags: a folder, an .mcap or a .db3, also split or compressed."""

import zlib
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NoReturn

from seatrial.io.bags.bag import LATEST, SALVAGE, Bag, Message, Topic, merged_topics
from seatrial.io.bags.bounded_rosbags import UriPath, bound_rosbags
from seatrial.io.bags.unpack import check_chunks, check_database
from seatrial.io.bags.wire import plain
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.files import read_yaml, yaml_text

SUFFIXES = (".mcap", ".db3")
METADATA = "metadata.yaml"
# raised by rosbags on damaged bytes, besides its own errors
ODD_BYTES = (ValueError, TypeError, KeyError, IndexError, AssertionError, AttributeError,
             OverflowError, MemoryError, EOFError, RuntimeError, RecursionError, OSError,
             zlib.error)  # fmt: skip


class Ros2Bag(Bag):
    """One rosbag2 recording, or one of its files. Raises RecordingError."""

    kind = "ROS 2 bag"

    def __init__(self, path: Path) -> None:
        from rosbags.interfaces import MessageDefinitionFormat
        from rosbags.rosbag2 import Reader

        self.path = path
        self.files = storage_files(path)
        bound_rosbags()
        for file in self.files:
            if file.suffix == ".db3":
                check_database(file)
        try:
            self._reader: Reader = Reader(UriPath(path))
            self._reader.open()
        except Exception as error:  # noqa: BLE001, RUF100 see _explained
            raise _explained(path, error) from None
        self._check_chunks()
        reader, folder = self._reader, path.is_dir()
        self.spans = _spans(path) if folder else ((reader.start_time, reader.end_time),)
        listed = reader.connections
        entries = [(c.topic, c.msgtype, c.msgcount, c.msgdef.data) for c in listed]
        if any([type(x) for x in entry] != [str, str, int, str] for entry in entries):
            self.close()
            raise RecordingError(f"{path}: the bag's list of topics is damaged; {SALVAGE}")
        idl = [c.msgdef.format is MessageDefinitionFormat.IDL for c in listed]
        self.topics = merged_topics(
            [Topic(*entry, idl=is_idl) for entry, is_idl in zip(entries, idl, strict=True)]
        )

    def _check_chunks(self) -> None:
        """Raise RecordingError where the chunks of an .mcap become too large."""
        own = self._reader.storage
        for file in getattr(own, "storages", [own]):
            chunks = getattr(file, "chunks", [])
            found = [(c.chunk_start_offset, c.compressed_size, c.uncompressed_size) for c in chunks]
            try:
                check_chunks(self.path, found, sum(f.stat().st_size for f in self.files))
            except RecordingError:
                self.close()
                raise

    def close(self) -> None:
        """Close the files."""
        self._reader.close()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics."""
        wanted = [c for c in self._reader.connections if c.topic in names]
        if not wanted:
            return
        try:
            for connection, stamp, data in self._reader.messages(connections=wanted):
                if type(data) is not bytes or type(stamp) is not int or not 0 <= stamp <= LATEST:
                    _refuse(self.path, connection.topic)
                yield connection.topic, stamp, data
        except Exception as error:  # noqa: BLE001, RUF100 see _explained
            raise _explained(self.path, error) from None


def _spans(folder: Path) -> tuple[tuple[int, int], ...]:
    """First and last arrival [ns] in each file by the folder's metadata; none where they do not state them."""
    try:
        files = read_yaml(folder / METADATA)["rosbag2_bagfile_information"]["files"]
        begins = [int(f["starting_time"]["nanoseconds_since_epoch"]) for f in files]
        lengths = [int(f["duration"]["nanoseconds"]) for f in files]
    except (FileError, KeyError, TypeError, ValueError):
        return ()
    return tuple((a, a + b) for a, b in zip(begins, lengths, strict=True))


def unusable_metadata(folder: Path) -> str:
    """Why a folder's metadata do not describe the files in it; empty where they do.

    A recorder that was stopped hard leaves them empty or of an earlier state.
    """
    try:
        text = yaml_text(folder / METADATA)
    except FileError:
        return "can't be read"
    if not text.strip():
        return "is empty"
    try:
        found = read_yaml(folder / METADATA)["rosbag2_bagfile_information"]
        listed = {Path(str(name)).name for name in found["relative_file_paths"]}
        count = int(found["message_count"])
    except (FileError, KeyError, TypeError, ValueError):
        return "does not describe a bag"
    there = {file.name for file in storage_files(folder)}
    if count == 0:
        return "counts no message"
    if unlisted := sorted(there - listed):
        return f"does not list {plain(', '.join(unlisted[:3]), 200)}"
    return ""


def storage_files(path: Path) -> tuple[Path, ...]:
    """The files that hold a ROS 2 recording's messages."""
    if path.is_file():
        return (path,)
    found = [p for p in path.iterdir() if p.suffix in SUFFIXES or p.name.endswith(".zstd")]
    return tuple(sorted(found, key=by_number))


def by_number(path: Path) -> tuple[int, str]:
    """Split files in their order: run_2 before run_10."""
    digits = path.name.split(".")[0].rpartition("_")[2]
    return (int(digits) if digits.isdecimal() else 0, path.name)


def _refuse(path: Path, topic: str) -> NoReturn:
    raise RecordingError(
        f"{path}: the bag is damaged (a message on {topic} has no time or content); {SALVAGE}"
    )


def _explained(path: Path, error: Exception) -> RecordingError:
    """A RecordingError for an error of rosbags; any other error is raised as it is."""
    from apsw import Error as SqliteError
    from rosbags.rosbag2 import ReaderError

    if isinstance(error, RecordingError):
        return error
    known = (ReaderError, SqliteError, *ODD_BYTES)
    if not isinstance(error, known) and type(error).__name__ not in ("ZstdError", "error"):
        raise error
    text = plain(str(error), 200) or type(error).__name__
    if "seems to be empty" in text or (path.is_file() and path.stat().st_size == 0):
        return RecordingError(f"{path}: is empty; was anything recorded?")
    if "File magic is invalid" in text or "not a database" in text:
        return RecordingError(f"{path}: is not a ROS 2 bag; is it another file, renamed?")
    if "magic is invalid" in text:
        return RecordingError(f"{path}: has no end: was the recording cut off? {SALVAGE}")
    if "Profile is not ros2" in text:
        return RecordingError(f"{path}: is an MCAP file, but not one of ROS 2; convert it to one")
    return RecordingError(f"{path}: the bag is damaged ({text}); {SALVAGE}")
