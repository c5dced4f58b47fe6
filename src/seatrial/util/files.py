# SPDX-License-Identifier: MIT
"""Text files: strict reading, atomic writing."""

import difflib
import hashlib
import json
import math
import os
import re
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args, get_origin

import msgspec
import yaml

from seatrial.util.errors import FileError

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

S = TypeVar("S", bound=msgspec.Struct)
DIGITS = 10  # significant digits of numbers in YAML files
MOST_BYTES = 64_000_000  # of a YAML or JSON file
MOST_VALUES, MOST_DEPTH = 200_000, 50  # of a file: bounds one that refers to itself


class _Loader(yaml.CSafeLoader if hasattr(yaml, "CSafeLoader") else yaml.SafeLoader):  # type: ignore[misc]
    """YAML 1.2's booleans and numbers (1e-3 is a number, `on` is a word); keys are unique."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Refuse a duplicate key."""
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if isinstance(key, (list, dict)):
                raise yaml.constructor.ConstructorError(
                    None, None, "a key must be a word", key_node.start_mark
                )
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"key '{key}' stands twice", key_node.start_mark
                )
            seen.add(key)
        return dict(super().construct_mapping(node, deep))


_Loader.yaml_implicit_resolvers = {
    first: [
        (tag, pattern)
        for tag, pattern in rules
        if not tag.endswith((":bool", ":int", ":float", ":timestamp"))
    ]
    for first, rules in _Loader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:bool", re.compile(r"^(?:true|True|false|False)$"), list("tTfF")
)
_INT = (  # 01500 is 1500: YAML 1.1's 832 is octal, which nobody means
    "tag:yaml.org,2002:int",
    re.compile(r"^[-+]?\d{1,300}$|^0o[0-7]{1,100}$|^0x[\da-fA-F]{1,100}$"),
    list("-+0123456789"),
)
_FLOAT = (
    "tag:yaml.org,2002:float",
    re.compile(
        r"^[-+]?(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d+)?$|^[-+]?\.(?:inf|Inf)$|^\.(?:nan|NaN)$"
    ),
    list("-+.0123456789"),
)
_Loader.add_implicit_resolver(*_INT)
_Loader.add_implicit_resolver(*_FLOAT)


def _whole_number(loader: _Loader, node: yaml.ScalarNode) -> int:
    """A whole number of YAML 1.2."""
    text = str(loader.construct_scalar(node))
    return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))


_Loader.add_constructor("tag:yaml.org,2002:int", _whole_number)


def yaml_text(path: "Path | Traversable") -> str:
    """The text of a YAML file. Raises FileError where it is too large or deep."""
    try:
        with path.open("rb") as file:
            raw = b""
            while len(raw) <= MOST_BYTES and (block := file.read(1 << 20)):
                raw += block
        if len(raw) > MOST_BYTES:
            raise FileError(f"{path}: expected a YAML file below {MOST_BYTES / 1e6:.0f} MB")
        text = raw.decode("utf-8")
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise FileError(f"{path}: is not text; expected a YAML file: is it a recording?") from None
    except OSError as error:
        raise FileError(f"{path}: can't be read ({error.strerror})") from None
    with suppress(yaml.YAMLError):  # which its reader raises
        _check_depth(text, path)
    return text


def read_yaml(path: "Path | Traversable") -> dict[str, Any]:
    """A YAML mapping. Raises FileError with file and line."""
    text = yaml_text(path)
    try:
        content = yaml.load(text, Loader=_Loader)
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
    for event in yaml.parse(text, Loader=_Loader):
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
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise FileError(
                f"{path}: is {size / 1e6:.0f} MB; expected a JSON file below {MOST_BYTES / 1e6:.0f} MB"
            )
        content = msgspec.json.decode(path.read_bytes())
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except OSError as error:
        raise FileError(f"{path}: can't be read ({error.strerror})") from None
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
        problem = _explain(str(error), kind, _keys(content, kind, str(error)))
        raise FileError(f"{path}: {problem}") from None


def _keys(content: dict[str, Any], kind: type[S], message: str) -> list[str]:
    """Keys of mappings with free names, which msgspec's message leaves out."""
    found: list[str] = []
    *paths, _ = message.rpartition("`$")[2].split("[...]")
    at: object = content
    for part in paths:
        for step in part.strip(".").split("."):
            at = at.get(step) if isinstance(at, dict) and step else at
        if not isinstance(at, dict):
            break
        for key in at:
            try:
                msgspec.convert(_without(content, at, key), kind, strict=True)
            except msgspec.ValidationError as error:
                if str(error) == message:
                    found.append(str(key))
                    at = at[key]
                    break
    return found


def _without(content: object, mapping: dict[str, Any], key: str) -> object:
    """The content, in which the mapping has this key only."""
    if content is mapping:
        return {key: mapping[key]}
    if isinstance(content, dict):
        return {k: _without(value, mapping, key) for k, value in content.items()}
    if isinstance(content, list):
        return [_without(value, mapping, key) for value in content]
    return content


def write_text(path: Path, text: str) -> None:
    """`write_bytes` of text."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, content: bytes) -> None:
    """Write atomically: to a temporary file in the same folder, then rename.

    A link is followed; a device or pipe (/dev/stdout) is written to as it is.
    """
    path = path.resolve()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not path.is_file() and not path.is_dir():
            path.write_bytes(content)
            return
        if path.is_dir():
            raise FileError(f"{path}: is a folder; give a file name")
        _replace(path, content)
    except OSError as error:
        raise FileError(f"{path}: can't be written ({error.strerror})") from None


def _replace(path: Path, content: bytes) -> None:
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:100]}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(
                file.fileno()
            )  # before the rename, so that a power cut leaves the old file or the new
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
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
    return str(yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100))


def dump_json(content: object, *, ascii_only: bool = False) -> str:
    """Indented JSON; NaN is refused, as JSON has none."""
    return json.dumps(content, indent=1, allow_nan=False, ensure_ascii=ascii_only) + "\n"


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


class _Dumper(yaml.SafeDumper):
    pass


def _flow_list(dumper: yaml.SafeDumper, data: list[Any]) -> yaml.Node:
    short = all(isinstance(x, (int, float)) or (isinstance(x, str) and " " not in x) for x in data)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=short)


def _flow_mapping(dumper: yaml.SafeDumper, data: dict[str, Any]) -> yaml.Node:
    short = len(data) <= 4 and not any(isinstance(x, (list, tuple, dict)) for x in data.values())
    return dumper.represent_mapping("tag:yaml.org,2002:map", data, flow_style=short)


def _float(dumper: yaml.SafeDumper, data: float) -> yaml.Node:
    text = f"{data:.{DIGITS}g}"
    text = text if any(c in text for c in ".en") else text + ".0"
    text = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}.get(text, text)
    return dumper.represent_scalar("tag:yaml.org,2002:float", text)


def _text(dumper: yaml.SafeDumper, data: str) -> yaml.Node:
    """A string in double quotes where it has line breaks, which become spaces otherwise."""
    style = None if data.isprintable() else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", data, style=style)


_Dumper.add_implicit_resolver(*_INT)
_Dumper.add_implicit_resolver(*_FLOAT)  # a word that reads as a number is quoted
_Dumper.add_representer(list, _flow_list)
_Dumper.add_representer(tuple, lambda dumper, data: _flow_list(dumper, list(data)))
_Dumper.add_representer(dict, _flow_mapping)
_Dumper.add_representer(float, _float)
_Dumper.add_representer(str, _text)


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


def _explain(message: str, kind: type[msgspec.Struct], keys: Sequence[str] = ()) -> str:
    """msgspec's message with the place in plain words, the nearest key, the allowed values.

    `keys`: names that it leaves out of the place.
    """
    for key in keys:
        message = message.replace("[...]", f".{key}", 1)
    parts = re.fullmatch(r"(.*?)(?: - at (?:`key` in )?`\$(.*)`)?", message, re.DOTALL)
    text, place = (parts[1], parts[2] or "") if parts else (message, "")
    where = place.lstrip(".").replace("[...]", ".*")
    unknown = re.search(r"unknown field `(.+)`", text)
    if unknown:
        known = sorted(_all_fields(kind).keys() - {unknown[1]})
        near = difflib.get_close_matches(unknown[1], known, n=1)
        hint = f"; did you mean '{near[0]}'?" if near else ""
        return f"unknown key '{unknown[1]}'{' in ' + where if where else ''}{hint}"
    missing = re.search(r"missing required field `(.+)`", text)
    if missing:
        return f"key '{missing[1]}' is missing{' in ' + where if where else ''}"
    for word, plain in _PLAIN.items():
        text = text.replace(word, plain)
    text = text[:1].lower() + text[1:].replace("`", "'")
    if "enum value" in text:
        wanted = _all_fields(kind).get(where.rpartition(".")[2])
        allowed = ", ".join(_literals(wanted))
        number = "a number, or " if _has_number(wanted) else ""
        text = text.replace("invalid enum value", "got") + f"; expected {number}{allowed}"
    return f"{where or 'the file'}: {text}"


_PLAIN = {"`array`": "a list", "`object`": "a mapping", "`str`": "text", "`float`": "a number",
          "`object | null`": "a mapping", "`array | null`": "a list", "`float | null`": "a number",
          "`int`": "a whole number"}  # fmt: skip


def _literals(kind: object) -> list[str]:
    """The values that a Literal, an Enum, or a union with one, allows."""
    if isinstance(kind, type) and issubclass(kind, Enum):
        return [str(member.value) for member in kind]
    if get_origin(kind) is Literal:
        return [str(value) for value in get_args(kind)]
    return [text for part in get_args(kind) for text in _literals(part)]


def _has_number(kind: object) -> bool:
    """Whether a type, or a part of a union, is a number."""
    return kind in (int, float) or any(_has_number(part) for part in get_args(kind))


def _all_fields(kind: type[msgspec.Struct]) -> dict[str, Any]:
    """Every key that may stand somewhere in the file, with its type."""
    fields: dict[str, Any] = {}
    pending: list[Any] = [kind]
    seen: set[Any] = set()
    while pending:
        current = pending.pop()
        if isinstance(current, type) and issubclass(current, msgspec.Struct):
            if current in seen:
                continue
            seen.add(current)
            for field in msgspec.structs.fields(current):
                fields.setdefault(field.encode_name, field.type)
                pending.append(field.type)
        else:
            pending.extend(get_args(current))
    return fields
