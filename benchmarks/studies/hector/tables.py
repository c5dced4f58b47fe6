# SPDX-License-Identifier: MIT
"""The study's tables; all seeds of a case together."""

from collections.abc import Sequence

import numpy as np

import seatrial
from benchmarks.harness.markdown import table as markdown
from benchmarks.studies.hector.study import (
    ALONE,
    BY_NODE,
    GENTLE,
    ODOMETRY,
    TRUE,
    UNRELAYED,
    VELOCITY,
    Case,
    Outcome,
    Study,
)
from benchmarks.studies.slam.study import OFF, SEEDS
from benchmarks.studies.slam.tables import losses, pace, per_cent, percentile
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.statistics import NORMAL_95

PACES = (1, 3, 15)  # of the scans that one is given
MAIN = (ALONE, VELOCITY, ODOMETRY, BY_NODE)
AGGRESSIVE = [
    *(Case("aggressive", start, every) for every in PACES for start in MAIN),
    *(Case("aggressive", start, drop_outs=True) for start in MAIN),
    Case("aggressive", TRUE), Case("aggressive", UNRELAYED), Case("aggressive", GENTLE, PACES[-1]),
]  # fmt: skip
GENTLY = [
    *(Case("gentle", start, every) for every in (1, 15) for start in (ALONE, BY_NODE)),
    *(Case("gentle", start, drop_outs=True) for start in (ALONE, BY_NODE)),
]
FORCED = [
    *(Case("gentle", start, 3, forced=True) for start in (ALONE, ODOMETRY, BY_NODE)),
    *(Case("aggressive", start, 3, forced=True) for start in (ODOMETRY, BY_NODE)),
]
FIRST = [Case("aggressive", start) for start in (ALONE, BY_NODE, TRUE)]  # of the picture, one drive
CASES: dict[str, list[Case]] = {
    "hector-first": FIRST,
    "hector-aggressive": AGGRESSIVE, "hector-gentle": GENTLY, "hector-forced": FORCED,
    "hector-earlier": [], "hector-model": [],
}  # fmt: skip
HEAD = (
    "scans", "start estimate", "scans used, %", "start error, 95 %: mm", "mrad", "pose false, %",
    "false matches", "drives lost", "pose error, 95 %: mm", "mrad", "map cells off, %",
)  # fmt: skip


def matched(cases: Sequence[Case], outcomes: Sequence[Outcome]) -> str:
    """Start, match, pose and map by pace and start estimate."""
    rows = []
    for case in sorted(cases, key=lambda c: (c.drop_outs, c.every)):
        o = [x for x in outcomes if x.case == case]
        used = 100.0 * sum(x.used for x in o) / sum(x.scans for x in o)
        false, lost = losses([x.false for x in o])
        rows.append([
            pace(case.every, case.drop_outs), case.start, f"{used:.3g}",
            *percentile([x.start_error for x in o]), false, str(sum(x.false_matches for x in o)), lost,
            *percentile([x.error for x in o]), per_cent([x.map_error > OFF for x in o]),
        ])  # fmt: skip
    return markdown(HEAD, rows, text=2)


def forced(cases: Sequence[Case], outcomes: Sequence[Outcome]) -> str:
    """What comes after a start estimate that is false."""
    head = (
        "driving", "start estimate", "pose false after it, %", "drives lost", "map cells off, %",
    )  # fmt: skip
    rows = []
    for case in cases:
        o = [x for x in outcomes if x.case == case]
        rows.append([
            case.driving, case.start, per_cent([x.after for x in o]), losses([x.false for x in o])[1],
            per_cent([x.map_error > OFF for x in o]),
        ])  # fmt: skip
    return markdown(head, rows, text=2)


def coefficients(models: dict[str, seatrial.Model]) -> str:
    """True and identified."""
    (gentle, both), found = models.values(), []
    true = plant_model(load_plan("hard"), seatrial.load_vehicle("mallard-mp"))
    for i, name in enumerate(true.vehicle.structure.coefficients):
        cells = [
            f"{m.coefficients[i]:.3g} ± {NORMAL_95 * float(np.sqrt(m.covariance[i, i])):.2g}"
            for m in (gentle, both)
        ]
        found.append([name, f"{true.coefficients[i]:.3g}", *cells])
    return markdown(("coefficient", "true", "of gentle drives", "and of hard ones"), found)


def table(name: str, study: Study) -> str:
    """Markdown."""
    if name == "hector-model":
        return coefficients(study.models)
    if name == "hector-earlier":
        return matched(list(dict.fromkeys(o.case for o in study.earlier)), study.earlier)
    if name == "hector-first":
        return matched(FIRST, [o for o in study.outcomes if o.seed == SEEDS[0]])
    return (forced if name == "hector-forced" else matched)(CASES[name], study.outcomes)
