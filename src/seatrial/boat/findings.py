# SPDX-License-Identifier: MIT
"""What an estimator or a validation found, as a value: kind, subject and numbers. Text is made of it last.

Values are in SI and forward-left-up axes. Code asks for the kind of a finding, never for its wording.
"""

import math
import shlex
import string
from collections.abc import Collection, Iterable, Mapping
from typing import Any, NoReturn

import msgspec

from seatrial.boat.finding_kinds import ASK_FOR_ACTION, PART_CHOICES, FindingKind
from seatrial.boat.finding_texts.spec import NAMES
from seatrial.util.format import joined

__all__ = [
    "Finding", "FindingKind", "advice_of", "finding_of", "finding_text", "most_important", "of_kinds",
    "sentence_of",
]  # fmt: skip

MOST_NAMES = 10_000  # of a subject: a file may hold anything
LONGEST_TEXT = 10_000  # [characters] of a name or a word

Value = float | str | tuple[float, ...]

# those that ask for an action first, then in the order of the kinds
_ORDER = [*ASK_FOR_ACTION, *(kind for kind in FindingKind if kind not in ASK_FOR_ACTION)]
_RANK = {kind: i for i, kind in enumerate(_ORDER)}


class Values(dict[str, Value]):
    """Values by name that can't be changed."""

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise TypeError("the values of a finding can't be changed")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type["Values"], tuple[dict[str, Value]]]:
        """For copies and other processes."""
        return Values, (dict(self),)


class Finding(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One finding. Raises ValueError where subject or values are not those of its kind.

    kind: what was found: sentence and advice
    subject: names of parameters, axes, recordings, actuators
    values: by the kind's names; numbers in SI
    """

    kind: FindingKind
    subject: tuple[str, ...] = ()
    values: dict[str, Value] = {}

    def __post_init__(self) -> None:
        _check_subject(self)
        msgspec.structs.force_setattr(self, "values", Values(_checked_values(self)))

    def __hash__(self) -> int:
        return hash((self.kind, self.subject, tuple(sorted(self.values))))

    def number(self, name: str) -> float:
        """A number by name."""
        value = self.values[name]
        assert isinstance(value, float)
        return value

    def part(self, name: str) -> str:
        """A part of the subject by its name: `finding.part("axis")`."""
        return self.subject[list(self.kind.spec.subject).index(name)]

    def in_axes(self, flipped: Collection[str]) -> "Finding":
        """The finding in axes in which some parameters have the other sign."""
        own = self.kind.spec.parameter
        if not own or not set(self.subject) & set(flipped):
            return self
        turned = {name: -self.number(name) for name in own}
        return Finding(self.kind, self.subject, {**self.values, **turned})


def finding_of(kind: FindingKind, *subject: str, **values: Value) -> Finding:
    """`finding_of(FindingKind.AT_BOUND, "lag", bound=0.002)`."""
    return Finding(kind, subject, values)


def of_kinds(findings: Iterable[Finding], *kinds: FindingKind) -> tuple[Finding, ...]:
    """Those of some kinds."""
    return tuple(finding for finding in findings if finding.kind in kinds)


def most_important(findings: Iterable[Finding]) -> list[Finding]:
    """In the order in which a user should look at them."""
    return sorted(findings, key=lambda finding: _RANK[finding.kind])


def finding_text(finding: Finding, flipped: Collection[str] = ()) -> str:
    """What was found and what to do, as one line. `flipped`: parameters whose sign the shown axes change."""
    parts = [sentence_of(finding, flipped), advice_of(finding, flipped)]
    return ". ".join(part for part in parts if part).replace("?. ", "? ")


def sentence_of(finding: Finding, flipped: Collection[str] = ()) -> str:
    """What was found, and what it means."""
    return _filled(finding.kind.sentence, finding.in_axes(flipped))


def advice_of(finding: Finding, flipped: Collection[str] = ()) -> str:
    """What to do; empty where there is nothing."""
    return _filled(finding.kind.advice, finding.in_axes(flipped))


def _filled(template: str, finding: Finding) -> str:
    """A template with the finding's subject and values, as one printable line."""
    line = _FORMAT.vformat(template, (), _fields(finding))
    return "".join(c if c.isprintable() else " " for c in line)


class _Format(string.Formatter):
    """Shares in per cent (`.0%`, `.2g%`), angles [rad] in degrees (`.2deg`); all else as usual."""

    def format_field(self, value: Any, format_spec: str) -> str:  # noqa: ANN401
        """One field."""
        if format_spec.endswith("deg"):
            return format(math.degrees(value), f"{format_spec[:-3]}g")
        if format_spec.endswith("%"):
            digits = format_spec.removesuffix("%").removesuffix("g")
            kind = "g" if "g" in format_spec else "f"
            return f"{100.0 * value:{digits}{kind}} %"
        return format(value, format_spec)


_FORMAT = _Format()


def _fields(finding: Finding) -> dict[str, object]:
    """All that sentence and advice may name."""
    spec, fields = finding.kind.spec, dict[str, object](finding.values)
    rest = list(finding.subject)
    for name, how_many in spec.subject.items():
        fields[name] = joined(rest) if how_many == NAMES else rest.pop(0)
        fields[f"{name}_quoted"] = shlex.quote(str(fields[name]))
    for name, meanings in spec.words.items():
        fields[f"{name}_means"] = (meanings or {}).get(str(finding.values[name]), "")
    for name in spec.each:
        numbers = finding.values[name]
        assert isinstance(numbers, tuple)
        pairs = zip(finding.subject, numbers, strict=True)
        fields[name] = ", ".join(f"{one}: {number:.4g}" for one, number in pairs)
    return fields


def _check_subject(finding: Finding) -> None:
    """Raise ValueError where there are not the parts that the kind has."""
    parts, got = finding.kind.spec.subject, finding.subject
    many = NAMES in parts.values()
    if len(got) < len(parts) or (len(got) > len(parts) and not many):
        expected = ", ".join(parts) or "none"
        raise ValueError(f"{finding.kind.value} has {len(got)} subjects; expected {expected}")
    if len(got) > MOST_NAMES or any(len(name) > LONGEST_TEXT for name in got):
        raise ValueError(f"{finding.kind.value}: its subject is too long")
    if not all(got):
        raise ValueError(f"{finding.kind.value}: a subject is empty")
    for i, part in enumerate(parts):
        named = got[i:] if parts[part] == NAMES else got[i : i + 1]
        odd = set(named) - set(PART_CHOICES.get(part, named))
        if odd:
            expected = ", ".join(PART_CHOICES[part])
            raise ValueError(f"{finding.kind.value}: {part} is '{min(odd)}'; expected {expected}")


def _checked_values(finding: Finding) -> dict[str, Value]:
    """The values, whole numbers as floats. Raises ValueError where they are not those of the kind."""
    spec, kind, got = finding.kind.spec, finding.kind.value, finding.values
    expected = [*spec.numbers, *spec.words]
    if set(got) != set(expected):
        names = ", ".join(expected) or "none"
        raise ValueError(f"{kind} has values {', '.join(sorted(got)) or 'none'}; expected {names}")
    return {
        name: _word(kind, name, got[name], spec.words[name])
        if name in spec.words
        else _number(finding, name, got[name])
        for name in expected
    }


def _word(kind: str, name: str, value: object, choices: Mapping[str, str] | None) -> str:
    if not isinstance(value, str) or len(value) > LONGEST_TEXT:
        raise ValueError(f"{kind}: {name} must be text of at most {LONGEST_TEXT} characters")
    if choices is not None and value not in choices:
        raise ValueError(f"{kind}: {name} is '{value}'; expected {', '.join(choices)}")
    return value


def _number(finding: Finding, name: str, value: object) -> float | tuple[float, ...]:
    spec, kind = finding.kind.spec, finding.kind.value
    several = name in spec.each
    numbers = value if isinstance(value, (tuple, list)) else (value,)
    if several != isinstance(value, (tuple, list)) or (
        several and len(numbers) != len(finding.subject)
    ):
        wanted = "a number for each subject" if several else "a number"
        raise ValueError(f"{kind}: {name} must be {wanted}")
    for number in numbers:
        sound = isinstance(number, (int, float)) and not isinstance(number, bool)
        if not sound or not math.isfinite(number):
            raise ValueError(f"{kind}: {name} is not a finite number")
        if number < 0.0 and name not in spec.signed:
            raise ValueError(f"{kind}: {name} is {number:g}; expected at least 0")
    found = tuple(float(number) for number in numbers)
    return found if several else found[0]
