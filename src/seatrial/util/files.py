# SPDX-License-Identifier: MIT
"""Text files: strict reading, atomic writing."""

import hashlib
import json
import math
import os
import secrets
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec
import yaml

from seatrial.util.errors import FileError, SeatrialError
from seatrial.util.file_content.explanations import explained, keys_left_out
from seatrial.util.file_content.yaml_dialect import Dumper, Loader

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

S = TypeVar("S", bound=msgspec.Struct)
MOST_BYTES = 64_000_000  # of a YAML or JSON file
# [characters] of a name in that of its temporary file: at most 160 of 255 bytes
LONGEST_BEGINNING = 40
MOST_VALUES, MOST_DEPTH = 200_000, 50  # of a file: bounds one that refers to itself


def yaml_text(path: "Path | Traversable") -> str:
    """The text of a YAML file. Raises FileError where it is too large or deep."""
    try:
        text = _bytes_of(path, "YAML").decode("utf-8")
    except UnicodeDecodeError:
        raise FileError(f"{path}: is not text; expected a YAML file: is it a recording?") from None
    with suppress(yaml.YAMLError):  # which its reader raises
        _check_depth(text, path)
    return text


@contextmanager
def readable(path: object, error: type[SeatrialError] = FileError) -> Iterator[None]:
    """What the system refuses inside is `error`: the file can't be read."""
    try:
        yield
    except OSError as found:
        raise error(f"{path}: can't be read ({found.strerror or found})") from None


@contextmanager
def writable(path: object) -> Iterator[None]:
    """The same: it can't be written. Raises FileError."""
    try:
        yield
    except OSError as found:
        raise FileError(f"{path}: can't be written ({found.strerror or found})") from None


def _bytes_of(path: "Path | Traversable", kind: str) -> bytes:
    """What stands in a file of this kind. Raises FileError where it is too large, or can't be read."""
    raw = b""
    try:
        with path.open("rb") as file:
            while len(raw) <= MOST_BYTES and (block := file.read(1 << 20)):
                raw += block
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise FileError(
            f"{path}: is a folder; expected a {kind} file: is it a recording?"
        ) from None
    except OSError as error:
        raise FileError(f"{path}: can't be read ({error.strerror})") from None
    if len(raw) > MOST_BYTES:
        raise FileError(f"{path}: expected a {kind} file below {MOST_BYTES / 1e6:.0f} MB")
    return raw


def read_yaml(path: "Path | Traversable") -> dict[str, Any]:
    """A YAML mapping. Raises FileError with file and line."""
    text = yaml_text(path)
    try:
        content = yaml.load(text, Loader=Loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or str(error).splitlines()[0]
        problem = problem.replace("character '\\t' that", "a tab (use spaces), which")
        raise FileError(f"{path}:{where} is not YAML: {problem}") from None
    if not isinstance(content, dict):
        raise FileError(f"{path}: expected 'key: value' lines, got {type(content).__name__}")
    _check_size(content, path)
    return content


def _check_depth(text: str, path: object) -> None:
    """Raise FileError for deep nesting, by events: the C parser's own recursion ends in a crash."""
    depth = 0
    for event in yaml.parse(text, Loader=Loader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MOST_DEPTH:
            where = f"line {event.start_mark.line + 1}" if event.start_mark else "it"
            raise FileError(f"{path}: {where} is more than {MOST_DEPTH} lists or mappings deep")


def _check_size(content: object, path: object) -> None:
    """Raise FileError where references (*name) make a small file a huge or endless one."""
    pending, count = [(content, 0)], 0
    while pending:
        value, depth = pending.pop()
        count += 1
        if count > MOST_VALUES or depth > MOST_DEPTH:
            raise FileError(
                f"{path}: has more than {MOST_VALUES} values, or {MOST_DEPTH} within each other; does "
                "something in it refer to itself?"
            )
        if isinstance(value, (dict, list)):
            inner = value.values() if isinstance(value, dict) else value
            pending += [(each, depth + 1) for each in inner]


def read_json(path: Path) -> dict[str, Any]:
    """A JSON mapping. Raises FileError."""
    try:
        content = msgspec.json.decode(_bytes_of(path, "JSON"))
    except (msgspec.DecodeError, RecursionError) as error:
        raise FileError(f"{path}: is not JSON: {error}") from None
    if not isinstance(content, dict):
        raise FileError(f"{path}: expected a JSON object, got {type(content).__name__}")
    return content


def expect_format(
    content: dict[str, Any], expected: str, path: object, earlier: Sequence[str] = ()
) -> dict[str, Any]:
    """The content of a file of this format, or of an `earlier` version. Raises FileError."""
    kind = content.get("seatrial")
    if kind != expected and kind not in earlier:
        found = f"says 'seatrial: {kind}'" if kind is not None else "has no line 'seatrial: ...'"
        raise FileError(
            f"{path}: {found}; expected 'seatrial: {expected}': is it another file, or from another "
            "version of seatrial?"
        )
    return content


def convert(content: dict[str, Any], kind: type[S], path: object, *, finite: bool = True) -> S:
    """A mapping as a typed struct; unknown keys, wrong types, NaN: one clear line each.

    `finite`: numbers that are not finite are refused.
    """
    for place, value in _numbers(content, "") if finite else ():
        if not math.isfinite(value):
            raise FileError(f"{path}: {place}: {value} is not a finite number")
    try:
        return msgspec.convert(content, kind, strict=True)
    except msgspec.ValidationError as error:
        problem = explained(str(error), kind, keys_left_out(content, kind, str(error)))
        raise FileError(f"{path}: {problem}") from None


def write_text(path: Path, text: str) -> None:
    """`write_bytes` of text."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, content: bytes) -> None:
    """`write_chunks` of one."""
    write_chunks(path, [content])


def write_chunks(path: Path, chunks: Iterable[bytes]) -> None:
    """Write atomically: to a temporary file in the same folder, then rename. Raises FileError.

    A link is followed; a device or pipe (/dev/stdout) is written to as it is.
    """
    path = path.resolve()
    with writable(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not path.is_file() and not path.is_dir():
            with path.open("wb") as file:
                file.writelines(chunks)
            return
        if path.is_dir():
            raise FileError(f"{path}: is a folder; give a file name")
        _replace(path, chunks)


def _replace(path: Path, chunks: Iterable[bytes]) -> None:
    beginning = path.name[:LONGEST_BEGINNING]
    temporary = path.with_name(f".{beginning}.{secrets.token_hex(8)}")
    try:
        with temporary.open("xb") as file:  # with the permissions that the user's mask leaves
            file.writelines(chunks)
            file.flush()
            # before the rename, so that a power cut leaves the old file or the new
            os.fsync(file.fileno())
        temporary.replace(path)
        sync_folder(path.parent)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def sync_folder(folder: Path) -> None:
    """Write a folder's entries to the disk, where the system can."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def dump_yaml(content: dict[str, Any]) -> str:
    """Readable YAML: order kept, short lists on one line."""
    return str(yaml.dump(content, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=100))


def dump_json(content: object, *, ascii_only: bool = False) -> str:
    """Indented JSON; NaN is refused, as JSON has none."""
    return json.dumps(content, indent=1, allow_nan=False, ensure_ascii=ascii_only) + "\n"


def builtin(value: Any) -> Any:  # noqa: ANN401, as msgspec calls it
    """Paths and numbers of numpy as JSON has them."""
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no JSON")


def finite_or_none(content: Any) -> Any:  # noqa: ANN401
    """JSON has no infinity and no NaN: null (a boat that never moves has no ratio)."""
    if isinstance(content, dict):
        return {key: finite_or_none(value) for key, value in content.items()}
    if isinstance(content, list):
        return [finite_or_none(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content


def sha256(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        for block in iter(lambda: file.read(1 << 20), b""):
            digest.update(block)
    return digest.hexdigest()


def _numbers(content: object, place: str) -> Iterator[tuple[str, float]]:
    """Every float in nested mappings and lists, with its place."""
    if isinstance(content, float):
        yield place, content
    elif isinstance(content, dict):
        for key, value in content.items():
            yield from _numbers(value, f"{place}.{key}".lstrip("."))
    elif isinstance(content, list):
        for i, value in enumerate(content):
            yield from _numbers(value, f"{place}[{i}]")
