# SPDX-License-Identifier: MIT
"""Selection of terms: true terms kept, absent ones kept, what is called weak.

Six trials of 200 s (S1-S6, MP) and eight candidates that the plant lacks, for the paper-like and the
hard preset, with and without an unmodelled force of 4 % of full thrust that lasts 2 s.
"""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import seatrial
from seatrial.identification.selection.terms import given_candidates, select
from seatrial.simulation.plan import load_plan
from tests.boats.scenes import driven, pushed

TRIALS = ("S1", "S2", "S3", "S4", "S5", "S6")
ABSENT = (
    "X_v * v", "X_r * r", "Y_u * u", "Y_r * r", "N_v * v", "N_Fu * F_u", "X_Fv * F_v",
    "Y_Fv3 * F_v * F_v * F_v",
)  # fmt: skip
SCENES = ("paper-like", "hard", "paper-like pushed", "hard pushed")
LESS = 1000  # than the benchmark's seed


def work(scene: str, seed: int) -> dict[str, Any]:
    """Terms that are kept and terms that are called weak, of one scene and seed."""
    vehicle = seatrial.load_vehicle("mallard-mp")
    preset = scene.removesuffix(" pushed")
    plan = pushed(preset) if scene.endswith("pushed") else load_plan(preset)
    trials = driven(plan, vehicle, seed - LESS, TRIALS)
    recordings = [t.recording for t in trials.values()]
    found = select(recordings, vehicle, candidates=given_candidates(vehicle, ABSENT))
    return {
        "kept": [r.coefficient for r in found.rows if r.verdict.kept],
        "weak": [r.coefficient for r in found.rows if r.reason.startswith("weak")],
    }


def summary(records: Sequence[dict[str, Any]]) -> str:
    """A line for each scene."""
    mine = [r for r in records if r["group"] == "terms"]
    lines = [_line(scene, [r for r in mine if r["scene"] == f"terms {scene}"]) for scene in SCENES]
    head = (
        f"{'scene':<18} seeds  all true kept  without N_ud  absent kept: seeds, at most  "
        "N_ud weak  others weak or lost"
    )
    return "\n".join(["```", head, *filter(None, lines), "```\n"]) if any(lines) else ""


def _line(scene: str, records: Sequence[dict[str, Any]]) -> str:
    done = [r for r in records if "kept" in r]
    if not done:
        return ""
    own = set(seatrial.load_vehicle("mallard-mp").structure.coefficients)
    failed, n = len(records) - len(done), len(done)
    lost = [own - set(r["kept"]) for r in done]
    extra = [len(set(r["kept"]) - own) for r in done]
    odd = Counter(name for r in done for name in r["weak"] if name != "N_ud")
    odd += Counter(f"-{name}" for gone in lost for name in gone if name != "N_ud")
    return (
        f"{scene:<18} {n:>5}  {_share(sum(not x for x in lost), n):>13}  "
        f"{_share(sum(x <= {'N_ud'} for x in lost), n):>12}  "
        f"{_share(sum(x > 0 for x in extra), n):>18}, {max(extra):>7}  "
        f"{_share(sum('N_ud' in r['weak'] for r in done), n):>9}  "
        + (", ".join(f"{name} {count}" for name, count in odd.most_common()) or "none")
        + (f"; {failed} failed" if failed else "")
    )


def _share(count: int, of: int) -> str:
    return f"{100 * count / of:.1f} %"
