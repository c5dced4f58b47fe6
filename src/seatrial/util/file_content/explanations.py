# SPDX-License-Identifier: MIT
"""What msgspec finds wrong with the content of a file, in plain words."""

import difflib
import re
from collections.abc import Sequence
from enum import Enum
from typing import Any, Literal, TypeVar, get_args, get_origin

import msgspec

S = TypeVar("S", bound=msgspec.Struct)
_PLAIN = {"`array`": "a list", "`object`": "a mapping", "`str`": "text", "`float`": "a number",
          "`object | null`": "a mapping", "`array | null`": "a list", "`float | null`": "a number",
          "`int`": "a whole number", "`int | null`": "a whole number", "`str | null`": "text",
          "`bool | null`": "true or false", "`bool | str | null`": "true, false or a word",
          "expected `bool`": "expected true or false"}  # fmt: skip

_OTHER: dict[str, tuple[type, ...]] = {
    "a number": (int, float),
    "true or false": (bool,),
}  # beside words


def explained(message: str, kind: type[msgspec.Struct], keys: Sequence[str] = ()) -> str:
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
        other = "".join(f"{word}, or " for word, types in _OTHER.items() if _has(wanted, types))
        text = text.replace("invalid enum value", "got") + f"; expected {other}{allowed}"
    return f"{where or 'the file'}: {text}"


def keys_left_out(content: dict[str, Any], kind: type[S], message: str) -> list[str]:
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


def _literals(kind: object) -> list[str]:
    """The values that a Literal, an Enum, or a union with one, allows."""
    if isinstance(kind, type) and issubclass(kind, Enum):
        return [str(member.value) for member in kind]
    if get_origin(kind) is Literal:
        return [str(value) for value in get_args(kind)]
    return [text for part in get_args(kind) for text in _literals(part)]


def _has(kind: object, types: Sequence[type]) -> bool:
    """Whether a type, or a part of a union, is one of these."""
    return kind in types or any(_has(part, types) for part in get_args(kind))


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
