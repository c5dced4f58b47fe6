# SPDX-License-Identifier: MIT
"""The sentences that "model 2" and "scores 3" have, and how findings are read from them.

The wordings are those that these versions wrote, and stay as they are.
"""

import re
from collections.abc import Callable, Sequence

from seatrial.boat.findings import Finding, FindingKind, Value, finding_of
from seatrial.util.frames import AXES

NUMBER = r"[-+]?\d{1,20}(?:\.\d{1,20})?(?:e[-+]?\d{1,4})?"
STAGE_WORDS = {
    "a latency": "latency", "a lag": "lag", "a power": "power", "power": "power",
    "a reverse over forward": "reverse_ratio", "reverse over forward": "reverse_ratio",
}  # fmt: skip
NO_ZONE = "is that the dead zone, which was not sought (small commands thrust less for it)? Else, "
QUANTITY = r"thrust and drag|thrust|drag"

Found = re.Match[str]
Read = Callable[[Found], list[Finding]]


def _plain(kind: FindingKind, subject: str = "") -> Read:
    """Reads a finding from a match whose groups are its parts and values; `subject`: a part of several names."""

    def read(found: Found) -> list[Finding]:
        groups = found.groupdict()
        names = _names(groups.pop(subject)) if subject else ()
        one = [groups.pop(part) for part in kind.spec.subject if part in groups]
        values: dict[str, Value] = {
            name: text if name in kind.spec.words else float(text) for name, text in groups.items()
        }
        return [Finding(kind, (*names, *one), values)]

    return read


def _names(text: str) -> tuple[str, ...]:
    return tuple(part.strip() for part in text.split(", "))


def _axes(found: Found) -> list[Finding]:
    return [Finding(FindingKind.NO_BETTER_THAN_CONSTANT, tuple(found["axes"].split(" and ")))]


def _stage(found: Found) -> list[Finding]:
    stage, groups = STAGE_WORDS[found["stage"]], found.groupdict().get("groups")
    if groups is None:
        return [finding_of(FindingKind.CURVE_STAGE_SELECTED, stage=stage)]
    return [finding_of(FindingKind.GROUP_STAGES_SELECTED, *_names(groups), stage=stage)]


def _share(kind: FindingKind) -> Read:
    """A number that was written in per cent; a fit horizon as a share of one second."""

    def read(found: Found) -> list[Finding]:
        name = next(iter(kind.spec.numbers))
        return [Finding(kind, (), {name: float(found[name]) / 100.0})]

    return read


def _gains(found: Found) -> list[Finding]:
    weak = "several" if found["why"].startswith("several") else "one"
    groups = re.findall(r"\{gains: \{(.*?)\}\}", found["gains"])
    out = []
    for group in groups:
        pairs = [pair.rpartition(": ") for pair in group.split(", ")]
        values: dict[str, Value] = {"weak": weak, "gains": tuple(float(g) for _, _, g in pairs)}
        names = tuple(name for name, _, _ in pairs)
        out.append(Finding(FindingKind.UNEQUAL_THRUSTER_GAINS, names, values))
    return out


def _heading(found: Found) -> list[Finding]:
    values: dict[str, Value] = {
        "size": float(found["degrees"]) * 3.141592653589793 / 180.0,
        "psi_offset": float(found["psi_offset"]),
    }
    return [Finding(FindingKind.HEADING_OFFSET, (), values)]


def _changes(found: Found) -> list[tuple[str, float, str, str]]:
    """Axis, share, where less and where more, of `in surge 12 %, in yaw 8 % less in B than in A; ...`."""
    out = []
    for part in found["places"].split("; "):
        shares, _, where = part.partition(" less ")
        less, _, more = where.partition(" than ")
        for each in re.finditer(rf"in ({'|'.join(AXES)}) ({NUMBER}) %", shares):
            out.append((each[1], float(each[2]) / 100.0, less, more))
    return out


def _zone(found: Found) -> str:
    return "not modelled" if found["rest"].startswith(NO_ZONE) else "modelled"


def _homogeneity(found: Found) -> list[Finding]:
    quantity, zone = found["quantity"], _zone(found)
    return [
        Finding(
            FindingKind.HOMOGENEITY,
            (axis, less.removeprefix("in "), more.removeprefix("in ")),
            {"change": change, "quantity": quantity, "dead_zone": zone},
        )
        for axis, change, less, more in _changes(found)
    ]


def _drift(found: Found) -> list[Finding]:
    out = []
    for axis, change, less, _ in _changes(found):
        lower, _, which = less.removeprefix("at the ").partition(" of ")
        longest = which.removeprefix("a recording like ")
        out.append(
            Finding(
                FindingKind.PARAMETER_DRIFT,
                (axis, longest),
                {
                    "change": change,
                    "quantity": found["quantity"],
                    "lower": lower,
                    "higher": "end" if lower == "beginning" else "beginning",
                    "of": "one recording" if longest == which else "all recordings",
                    "dead_zone": _zone(found),
                },
            )
        )
    return out


def _intervals(found: Found) -> list[Finding]:
    """Disturbed intervals, and what their exclusion changes, where the note has it."""
    ratio = float(found["ratio"].rpartition(" to ")[2])
    out = []
    for part in found["where"].split("; "):
        name, _, spans = part.partition(" from ")
        for start, end in re.findall(rf"({NUMBER}) s to ({NUMBER}) s", spans):
            values: dict[str, Value] = {"start": float(start), "end": float(end), "ratio": ratio}
            out.append(Finding(FindingKind.DISTURBED_INTERVAL, (name,), values))
    if found["parameter"]:
        numbers = {name: float(found[group]) for name, group in _INFLUENCE.items()}
        kind = FindingKind.DISTURBANCE_INFLUENCE
        out.append(Finding(kind, (found["parameter"],), dict[str, Value](numbers)))
    return out


_INFLUENCE = {"ratio": "errors", "value": "value", "error": "error"}


def _conflict(found: Found) -> list[Finding]:
    """Parameters, and factors that an axis has in common."""
    out = []
    for each in re.finditer(
        rf"(?:^|, )(\S+) \(({NUMBER}) ± ({NUMBER}) to ({NUMBER}) ± ({NUMBER})\)", found["listed"]
    ):
        names = ("prior", "prior_error", "found", "found_error")
        numbers = dict(zip(names, map(float, each.groups()[1:]), strict=True))
        out.append(Finding(FindingKind.PRIOR_CONFLICT, (each[1],), dict[str, Value](numbers)))
    common = re.search(rf"(?:^|, )({QUANTITY}) \(([^()]*) of the prior's\)", found["listed"])
    for each in re.finditer(rf"({NUMBER}) in (\w+)", common[2] if common else ""):
        values: dict[str, Value] = {
            "quantity": common[1] if common else "",
            "factor": float(each[1]),
        }
        out.append(Finding(FindingKind.PRIOR_FACTOR, (each[2],), values))
    if not out:
        raise ValueError("a conflict of nothing")
    return out


def _unexpected(found: Found) -> list[Finding]:
    causes = {
        "it is gone further ahead": "pose noise",
        "though it was identified": "model mismatch",
    }
    cause = next((c for said, c in causes.items() if found["why"].startswith(said)), "change")
    return [
        Finding(
            FindingKind.EXCEEDS_EXPECTED_ERROR,
            (each[1],),
            {"ratio": float(each[2]), "horizon": float(each[3]), "cause": cause},
        )
        for each in re.finditer(rf"in (\w+) ({NUMBER}) times \(({NUMBER}) s ahead\)", found["each"])
    ]


_EFFECT = "more than half of the unmodelled force would be explained by "
_IF = ": if that may be, identify with --effect {0}, before further terms are sought"
_TOLD = rf"(?P<quantity>{QUANTITY}) (?P<places>.*?): (?P<rest>.*)"
WORDINGS: Sequence[tuple[str, Read]] = (
    (
        rf"(?P<parameter>.+): (?P<bound>{NUMBER}) is the bound of its range",
        _plain(FindingKind.AT_BOUND),
    ),
    (
        rf"standard errors of the lever arm: (?P<ahead>{NUMBER}) m ahead, (?P<aside>{NUMBER}) m aside",
        _plain(FindingKind.LEVER_ARM_ERRORS),
    ),
    (
        rf"the structure is not quite right: poses count as if noisier, by (?P<horizon>{NUMBER}) % of the way .*",
        _share(FindingKind.MODEL_MISMATCH),
    ),
    (
        r"(?P<stage>power|reverse over forward) of the thrust curve: estimated, as the data ask for it",
        _stage,
    ),
    (
        r"(?P<stage>a latency|a lag|a power|a reverse over forward) for each of (?P<groups>.+): "
        "estimated, as the data ask for it",
        _stage,
    ),
    (
        r"dead zone: not sought, as the commands are (?P<forces>.+), not thrusters'; .*",
        _plain(FindingKind.DEAD_ZONE_NOT_SOUGHT, "forces"),
    ),
    (
        r"dead zone(?: of [^:]+)?: one edge for both sides, as (?P<actuators>.+) hardly push (?P<side>\w+)",
        _plain(FindingKind.DEAD_ZONE_ONE_EDGE, "actuators"),
    ),
    (
        r"dead zone(?: of [^:]+)?: not identifiable, as under these commands of (?P<actuators>.+) it always "
        "takes .*",
        _plain(FindingKind.DEAD_ZONE_NOT_IDENTIFIABLE, "actuators"),
    ),
    (
        rf"(?P<parameter>\S+): taken as (?P<power>{NUMBER}), as (?P<signal>.+) hardly changes in the .*",
        _plain(FindingKind.SCALE_POWER_HELD),
    ),
    (
        rf"standard errors: from blocks of (?P<length>{NUMBER}) s, as the recordings are short",
        _plain(FindingKind.SHORT_BLOCKS),
    ),
    (
        rf"(?P<share>{NUMBER}) % of the poses are outliers to the model and count less",
        _share(FindingKind.OUTLIERS),
    ),
    (
        r"no coefficient differs clearly from zero: .*",
        _plain(FindingKind.NO_SIGNIFICANT_COEFFICIENT),
    ),
    (r"no second of these recordings can be predicted: .*", _plain(FindingKind.NOT_PREDICTABLE)),
    (
        r"in (?P<axes>\w+(?: and \w+)*), one second ahead hardly better than constant or zero velocity: .*",
        _axes,
    ),
    (
        rf"{_EFFECT}poses of a point about (?P<size>{NUMBER}) m off the origin, a lever arm{_IF.format('lever')}",
        _plain(FindingKind.UNMODELLED_LEVER_ARM),
    ),
    (
        rf"{_EFFECT}a current of up to (?P<size>{NUMBER}) m/s{_IF.format('current')}",
        _plain(FindingKind.UNMODELLED_CURRENT),
    ),
    (
        rf"{_EFFECT}a steady push, as of thrusters that are not quite at rest{_IF.format('trim')}",
        _plain(FindingKind.UNMODELLED_TRIM),
    ),
    (rf"{_EFFECT}wind{_IF.format('wind')}", _plain(FindingKind.UNMODELLED_WIND)),
    (
        rf"{_EFFECT}thrusters that do not thrust alike \((?P<why>.*?)\): if that may be, add (?P<gains>.*) to "
        "the vehicle file's chain and identify again, before further terms are sought",
        _gains,
    ),
    (
        rf"poses fit far better with a heading that is off by (?P<degrees>{NUMBER}) degrees: .* write offset: "
        rf"(?P<psi_offset>{NUMBER}) at .*",
        _heading,
    ),
    (
        rf"the recordings do not agree: commands act (?P<delay>{NUMBER}) s later in (?P<later>.+) than in "
        "(?P<earlier>.+): were clocks .*",
        _plain(FindingKind.CLOCK_HOMOGENEITY),
    ),
    (rf"the recordings do not agree: {_TOLD}", _homogeneity),
    (rf"the boat changes in the course of a recording: {_TOLD}", _drift),
    (
        rf"poses are (?P<ratio>{NUMBER}(?: to {NUMBER})?) times as far from what is predicted as elsewhere in "
        r"(?P<where>.+?): was the boat held, .*? leave that out with .*?(?:\. Standard errors are then "
        rf"(?P<errors>{NUMBER}) times these, and (?P<parameter>.+), which changes most, is (?P<value>{NUMBER}) ± "
        rf"(?P<error>{NUMBER}))?",
        _intervals,
    ),
    (
        rf"Prior: an older model, widened by (?P<spread>{NUMBER}) % of every parameter\.",
        _share(FindingKind.PRIOR_USED),
    ),
    (r"Prior and recording contradict each other in (?P<listed>.*): more changed .*", _conflict),
    (
        r"The recording says little of (?P<parameters>.+): mostly the prior's values\.",
        _plain(FindingKind.PRIOR_DOMINATES, "parameters"),
    ),
    (
        r"The prior was identified from (?P<recordings>.+), too: what is in there counts twice; .*",
        _plain(FindingKind.PRIOR_COUNTED_TWICE, "recordings"),
    ),
    (r"no starts from a filter, no residuals: (?P<reason>.*)", _plain(FindingKind.NO_FILTER)),
    (r"the error is (?P<each>.*) what the model foresees of itself: (?P<why>.*)", _unexpected),
    (
        rf"poses are (?P<period>{NUMBER}) s apart: the stencil's velocities, .*",
        _plain(FindingKind.SLOW_POSES),
    ),
)
