# SPDX-License-Identifier: MIT
"""Changes of a running boat: noticed, named, sized; false alarms; odometry. The tables of docs/changes.md.

    python -m benchmarks.studies.changes --seeds 20
    python -m benchmarks.studies.changes --seeds 20 --any-code --write    # what is there, into the page

The paper's boat in its pool, with a disturbance force of 4 % of full thrust. A seed has a model of S1 to S3, and
drives of S7: with each changed boat, and with the same boat in one weather. Every fourth has the low battery, too,
and the same boat that a hand moves once. A seed's results are kept when it ends.
"""

import sys
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.harness import command, store
from benchmarks.harness.markdown import table
from benchmarks.harness.page import refill
from benchmarks.studies.changes.boats import CHANGES, FIRST, Change
from benchmarks.studies.changes.weather import HAND, WEATHER
from benchmarks.studies.changes.work import Record, one
from seatrial.onboard.boat_change import ChangeState
from seatrial.util.statistics import NORMAL_95

PAGE = command.DOCS / "changes.md"
SOON = 30.0  # [s]
NOTICED = (
    "change", "drives", "noticed after (median)", f"within {SOON:.0f} s", "confirmed", "named rightly",
    "size in its 95 % interval", "RMS error of the size",
)  # fmt: skip
ALARMS = "the same boat", "driven", "noticed", "withdrawn", "confirmed", "CPU, of one core"
STATES = ChangeState.NOTICED, ChangeState.WITHDRAWN, ChangeState.CONFIRMED
ODOMETRY = "change", "before", "until adapted", "after, adapted", "after, `--adapt off`"


def changed(name: str, change: Change, found: Sequence[Record]) -> list[str]:
    """The row of a change: shares of all drives, sizes of those that were named rightly."""
    after = [np.inf if one["noticed"] is None else one["noticed"] for one in found]
    named = [one for one in found if _rightly(change, one)]
    off = np.array([one["size"] - change.size for one in named])
    stated = np.array([one["error"] for one in named])
    return [
        name, str(len(found)), f"{np.median(after):.0f} s", _share(np.array(after) <= SOON),
        _share(["confirmed" in one for one in found]), _share([_rightly(change, one) for one in found]),
        _share(np.abs(off) < NORMAL_95 * stated), f"{100 * np.sqrt(np.mean(off**2)):.1f} %",
    ]  # fmt: skip


def _rightly(change: Change, found: Record) -> bool:
    """Whether cause and part are right."""
    return found.get("cause") in change.causes and found["what"] == change.what


def _share(hits: Sequence[bool] | np.ndarray) -> str:
    return f"{100 * np.mean(hits):.1f} %".replace(".0 %", " %")


def unchanged(name: str, found: Sequence[Record]) -> list[str]:
    """The row of a weather: false alarms, and what the tests cost."""
    seconds, cpu = (sum(one[key] for one in found) for key in ("seconds", "cpu"))
    states = [state for one in found for state in one["states"]]
    counts = [str(states.count(state.value)) for state in STATES]
    return [name, f"{seconds / 3600:.1f} h", *counts, f"{100 * cpu / seconds:.1f} %"]


def odometry(name: str, before: Sequence[Record], found: Sequence[Record]) -> list[str]:
    """The row of a change: RMS errors at the end of drop-outs."""
    known = [one for one in found if "during" in one]
    phases = [before, *([one[key] for one in known] for key in ("during", "after", "off"))]
    return [name, *(_rms(phase) for phase in phases)]


def _rms(phase: Sequence[Record]) -> str:
    n, position, heading = np.sum(phase, axis=0)
    return f"{100 * np.sqrt(position / n):.1f} cm, {np.degrees(np.sqrt(heading / n)):.1f}°"


def tables(records: Sequence[Record]) -> Mapping[str, str]:
    """All tables by their names in the page."""
    of_change = {
        name: [r["changes"][name] for r in records if name in r["changes"]] for name in CHANGES
    }
    weather = {
        name: [r["weather"] for r in records if r["weather"]["name"] == name] for name in WEATHER
    }
    driven = {name: found for name, found in weather.items() if found}
    alarms = [unchanged(name, found) for name, found in driven.items()]
    alarms.append(unchanged("**all of these**", [r["weather"] for r in records]))
    alarms.append(unchanged(HAND, [r["hand"] for r in records if "hand" in r]))
    before = [r["before"] for r in records]
    return {
        "changes": table(
            NOTICED, [changed(n, CHANGES[n], found) for n, found in of_change.items()]
        ),
        "alarms": table(ALARMS, alarms),
        "odometry": table(ODOMETRY, [odometry(n, before, found) for n, found in of_change.items()]),
    }


def main(arguments: Sequence[str]) -> None:
    """Run, print, and write into the page on request."""
    parser = command.parser("studies.changes", __doc__)
    command.with_seeds(parser, 20, FIRST)
    parser.add_argument("--write", action="store_true", help="into the page")
    command.with_results(parser, "build/changes.jsonl")
    given = parser.parse_args(arguments)
    present = store.code("studies/changes")
    if not given.any_code:
        jobs = [(seed,) for seed in range(given.seeds)]
        store.run(given.results, jobs, one, present, given.workers)
    known = store.chosen(store.read(given.results), present, any_code=given.any_code)
    seeds = [record for record in known if record["job"][0] < given.seeds]
    made = tables([record for record in seeds if "failed" not in record])
    print(*made.values(), sep="\n\n")
    if given.write:
        refill(PAGE, made)


if __name__ == "__main__":
    main(sys.argv[1:])
