# SPDX-License-Identifier: MIT
"""Stamps [ns] from the cells of a table: numbers of any unit, seconds and nanoseconds, dates and times."""

import re
from collections.abc import Callable, Sequence
from datetime import date

import numpy as np

from seatrial.boat.schema import Column
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask, Stamps

TO_NANOSECONDS = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}
UNPADDED = "s.ns"  # seconds, a point, nanoseconds without leading zeros: 12.45 is 12.000000045 s
MOST_NANOSECONDS = 9e18  # [ns] below the largest 64-bit integer
DAY, HOUR = 86_400 * 10**9, 3600 * 10**9  # [ns]
NANOSECONDS_DIGITS = 9
EPOCH = date(1970, 1, 1).toordinal()
LEAST_BACKWARD = 3  # steps backward as plain seconds, that show nanoseconds without leading zeros
PADDED_BACKWARD = 0.1  # of these, steps that remain backward with leading zeros, at most
MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
DATE_TIME = re.compile(
    r"""\s*
    (?P<date>
        (?P<year>\d{4})(?P<mark>[-/.]?)(?P<month>\d{1,2})(?P=mark)(?P<day>\d{1,2})
      | (?P<first>\d{1,2})[-/.](?P<second>\d{1,2}|[A-Za-z]{3})[-/.](?P<last>\d{4})
    )?
    (?:(?<=\d)[T_,]?\s*|\s*)
    (?P<hour>\d{1,2}):?(?P<minute>\d{2}):?(?P<seconds>\d{2})(?:[.,](?P<rest>\d+))?
    \s*(?P<half>[AaPp][Mm])?
    \s*(?P<zone>Z|UTC|GMT|[-+]\d{2}:?(?:\d{2})?)?\s*""",
    re.VERBOSE,
)

WRAP_STEPS = 10.0  # usual steps, most from the last value of a counter's range to the next one
FEWEST_ROUNDED = 50  # rows
# of the rows that have the stamp of the row before: more than two rows a stamp
ROUNDED_SHARE = 0.55
# of the step between stamps, by which a row on an even clock may leave its stamp
ROUNDED_SLACK = 0.25

MINUTES = re.compile(r"\s*\d{1,3}:\d{2}[.,]\d+\s*")  # 59:07.3

Place = Callable[[int], str]  # a row as the error names it: `log.csv line 7`


def spread_evenly(stamps: Stamps) -> tuple[Stamps, str]:
    """Stamps (n,) [ns] of rows on an even clock that were cut off to whole steps, and what was found.

    As they are where they were not cut off, or the clock is not even.
    """
    steps = np.diff(stamps)
    apart = steps[steps != 0]
    if len(stamps) < FEWEST_ROUNDED or len(apart) < 3 or np.any(steps < 0):
        return stamps, ""
    unit = int(apart.min())
    if np.mean(steps == 0) < ROUNDED_SHARE or np.any(apart % unit):
        return stamps, ""
    number = np.arange(len(stamps))
    elapsed = (stamps - stamps[0]).astype(np.float64)
    even = np.asarray(np.polyval(np.polyfit(number, elapsed, 1), number), dtype=np.float64)
    late = even - elapsed  # a row that was cut off: 0 to one step
    if float(np.ptp(late)) > (1.0 + ROUNDED_SLACK) * unit:
        return stamps, ""
    even = even + 0.5 * (unit - float(late.max()) - float(late.min()))
    period = (even[-1] - even[0]) / (len(even) - 1)
    text = (
        f"stamps are whole steps of {unit * 1e-9:g} s with {unit / period:.3g} rows each; the rows are put on the "
        f"even clock of {1e9 / period:.4g} Hz that fits them"
    )
    return np.asarray(stamps[0] + np.rint(even).astype(np.int64)), text


def refuse_empty(empty: Mask, name: str, place: Place) -> None:
    """Raise RecordingError where a row has no stamp."""
    if empty.any():
        raise RecordingError(f"{place(int(empty.argmax()))}: column '{name}' has no stamp")


def from_numbers(raw: Array, column: Column, place: Place) -> Stamps:
    """Stamps (n,) of numbers in the column's unit. Raises RecordingError."""
    refuse_empty(~np.isfinite(raw), column.column, place)
    with np.errstate(over="ignore"):
        scale = TO_NANOSECONDS[column.unit or "s"]
        raw = unwrapped(raw, 1e9 / scale)
        stamps = column.sign * (raw - column.offset) / column.scale * scale
    if len(stamps) and np.abs(stamps).max() > MOST_NANOSECONDS:
        row = int(np.abs(stamps).argmax())
        raise RecordingError(
            f"{place(row)}: stamp column '{column.column}' reaches {raw[row]:g} {column.unit or 's'}; "
            "is its unit ms, us or ns? Name it in the vehicle file"
        )
    return np.rint(stamps).astype(np.int64)


def unwrapped(raw: Array, second: float) -> Array:
    """Numbers (n,) of a counter that began again at 0: of 16 or 32 bits, or seconds of a day or a GPS week.

    `second`: in the counter's unit. As they are where they fall otherwise.
    """
    steps = np.diff(raw)
    falls = steps < 0
    usual = float(np.median(steps)) if len(steps) else 0.0
    if not falls.any() or usual <= 0:
        return raw
    for turn in (2.0**16, 2.0**32, 86_400 * second, 604_800 * second):
        rest = steps[falls] + turn
        if raw.min() >= 0 and raw.max() < turn and np.all((rest > 0) & (rest < WRAP_STEPS * usual)):
            return np.asarray(raw + turn * np.concatenate([[0], np.cumsum(falls)]))
    return raw


def from_two_columns(seconds: Array, rest: Array, column: Column, place: Place) -> Stamps:
    """Stamps (n,) of whole seconds in one column and nanoseconds in another. Raises RecordingError."""
    for values, name in ((seconds, column.column), (rest, column.nanoseconds)):
        refuse_empty(~np.isfinite(values), name, place)
    odd = (seconds != np.rint(seconds)) | (rest < 0) | (rest >= 1e9)
    if odd.any():
        row = int(np.flatnonzero(odd)[0])
        raise RecordingError(
            f"{place(row)}: columns '{column.column}' and '{column.nanoseconds}' have {seconds[row]:g} and "
            f"{rest[row]:g}, expected whole seconds and 0 to 999999999 ns"
        )
    if len(seconds) and np.abs(seconds).max() * 1e9 > MOST_NANOSECONDS:
        row = int(np.abs(seconds).argmax())
        raise RecordingError(
            f"{place(row)}: stamp column '{column.column}' reaches {seconds[row]:g} s, which is no time"
        )
    return seconds.astype(np.int64) * 10**9 + np.rint(rest).astype(np.int64)


def from_unpadded(texts: Sequence[str], column: Column, place: Place) -> Stamps:
    """Stamps (n,) of seconds, a point and nanoseconds without leading zeros. Raises RecordingError."""
    found = [unpadded(text) for text in texts]
    if None in found:
        i = found.index(None)
        raise RecordingError(
            f"{place(i)}: column '{column.column}' has '{texts[i][:40]}', expected seconds, a point and at "
            f"most 9 digits of nanoseconds (unit {UNPADDED})"
        )
    return np.array(found, dtype=np.int64)


def unpadded(text: str) -> int | None:
    """12.45 as 12.000000045 s, in nanoseconds; None where it is no such number."""
    whole, _, rest = text.strip().partition(".")
    if not (whole.isdecimal() and (rest or "0").isdecimal()) or not (whole + rest).isascii():
        return None
    if len(rest) > NANOSECONDS_DIGITS or int(whole) * 10**9 > MOST_NANOSECONDS:
        return None
    return int(whole) * 10**9 + int(rest or "0")


def is_unpadded(texts: Sequence[str]) -> bool:
    """Whether these seconds jump back, and rise where the digits after the point are nanoseconds."""
    try:
        plain = np.array([float(text) for text in texts])
    except ValueError:
        return False
    with np.errstate(over="ignore", invalid="ignore"):
        backward = int((np.diff(plain) < 0).sum())
    if backward < LEAST_BACKWARD:
        return False
    padded = [unpadded(text) for text in texts]
    if any(value is None for value in padded):
        return False
    remaining = int((np.diff(np.array(padded, dtype=np.int64)) < 0).sum())
    return remaining <= PADDED_BACKWARD * backward


def is_date_time(text: str) -> bool:
    """Whether this is a date and time, or a time of day; a plain number is neither."""
    found = DATE_TIME.fullmatch(text)
    return (found is not None and (":" in text or "T" in text)) or bool(MINUTES.fullmatch(text))


def from_date_times(texts: Sequence[str], name: str, place: Place) -> Stamps:
    """Stamps (n,) of dates and times, or of times of day that may pass midnight. Raises RecordingError.

    Without a zone the time counts as UTC. Minutes and seconds with a fraction may pass the hour: spreadsheets
    leave the hours out. Fractions without leading zeros, 12:00:07.45 for 7.000000045 s, make stamps jump back.
    """
    turn = DAY
    if texts and all(map(MINUTES.fullmatch, texts)):
        texts, turn = [_with_hours(text) for text in texts], HOUR
    parts = []
    for i, text in enumerate(texts):
        found = DATE_TIME.fullmatch(text)
        if found is None:
            odd = f"has '{text[:40]}', expected a date and time"
            what = odd if text.strip() else "has no stamp"
            raise RecordingError(f"{place(i)}: column '{name}' {what}")
        parts.append(found)
    month_first = _month_first(parts)
    stamps = np.empty(len(parts), dtype=np.int64)
    days: dict[str, int] = {"": 0}
    for i, found in enumerate(parts):
        written = found["date"] or ""
        try:
            if written not in days:
                days[written] = _day(found, month_first=month_first)
            stamps[i] = days[written] * DAY + _time_of_day(found)
        except (ValueError, OverflowError):
            raise RecordingError(
                f"{place(i)}: column '{name}' has '{texts[i][:40]}', which is no date and time"
            ) from None
    stamps = _with_zeros(stamps, [found["rest"] or "" for found in parts])
    if not any(found["date"] for found in parts):  # a log that passes midnight
        falls = np.diff(stamps, prepend=stamps[:1]) < -turn // 2
        stamps += np.cumsum(falls) * turn
    return stamps


def _with_zeros(stamps: Stamps, rests: Sequence[str]) -> Stamps:
    """Stamps (n,) whose fractions of a second lack leading zeros, as they are with them; else as they are."""
    width = min(max(map(len, rests), default=0), NANOSECONDS_DIGITS)
    short = np.array([len(rest) < width for rest in rests], dtype=bool)
    backward = int((np.diff(stamps) < 0).sum())
    if not short.any() or backward < LEAST_BACKWARD:
        return stamps
    padded = stamps.copy()
    for i in np.flatnonzero(short).tolist():
        padded[i] += _fraction(rests[i].rjust(width, "0")) - _fraction(rests[i])
    remaining = int((np.diff(padded) < 0).sum())
    return padded if remaining <= PADDED_BACKWARD * backward else stamps


def _with_hours(text: str) -> str:
    """Minutes and seconds as hours, minutes and seconds."""
    minutes, _, seconds = text.strip().partition(":")
    hours, minute = divmod(int(minutes), 60)
    return f"{hours:02}:{minute:02}:{seconds}"


def _month_first(parts: Sequence[re.Match[str]]) -> bool:
    """Whether dates are 4/11/2025 for the eleventh of April: a second number is above 12."""
    return any((p["second"] or "").isdecimal() and int(p["second"]) > 12 for p in parts)


def _day(found: re.Match[str], *, month_first: bool) -> int:
    """Days since 1970."""
    if found["year"]:
        year, month, day = int(found["year"]), int(found["month"]), int(found["day"])
    else:
        year, first, second = int(found["last"]), int(found["first"]), found["second"]
        if not second.isdecimal():
            month, day = MONTHS.index(second.lower()) + 1, first
        else:
            month, day = (first, int(second)) if month_first else (int(second), first)
    if not 1900 <= year < 2200:
        raise ValueError(year)
    return date(year, month, day).toordinal() - EPOCH


def _time_of_day(found: re.Match[str]) -> int:
    """[ns], the zone subtracted."""
    hour, minute, second = int(found["hour"]), int(found["minute"]), int(found["seconds"])
    if found["half"]:
        hour = hour % 12 + 12 * (found["half"].lower() == "pm")
    if hour > 24 or minute > 59 or second > 60:
        raise ValueError(found[0])
    whole = ((hour * 60 + minute - _zone(found["zone"])) * 60 + second) * 10**9
    return whole + _fraction(found["rest"] or "")


def _fraction(digits: str) -> int:
    """[ns] of the digits after the point."""
    return int(digits[:NANOSECONDS_DIGITS].ljust(NANOSECONDS_DIGITS, "0"))


def _zone(text: str | None) -> int:
    """[min] east of UTC."""
    if not text or text[0] not in "+-":
        return 0
    digits = text[1:].replace(":", "").ljust(4, "0")
    return (-1 if text[0] == "-" else 1) * (int(digits[:2]) * 60 + int(digits[2:]))
