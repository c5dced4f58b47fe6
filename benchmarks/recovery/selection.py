# SPDX-License-Identifier: MIT
"""Selection over seeds: true terms kept, absent ones kept, what is called weak.

    python benchmarks/select_study.py --seeds 200 [--workers 2] [--scenes NAME,...]

Six trials of 200 s (S1-S6, MP) and eight candidates that the plant lacks, for the paper-like and the
hard preset, with and without an unmodelled force of 4 % of full thrust that lasts 2 s.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import msgspec

import seatrial
from seatrial.errors import SeatrialError
from seatrial.plan import PlanFile, Unmodelled, load_plan, with_seed
from seatrial.select import given_candidates, select
from seatrial.simulate import simulate

TRIALS = ("S1", "S2", "S3", "S4", "S5", "S6")
ABSENT = (
    "X_v * v", "X_r * r", "Y_u * u", "Y_r * r", "N_v * v", "N_Fu * F_u", "X_Fv * F_v",
    "Y_Fv3 * F_v * F_v * F_v",
)  # fmt: skip
FORCE = Unmodelled(share=0.04, correlation=2.0)
SCENES = ("paper-like", "hard", "paper-like pushed", "hard pushed")


def plan_of(scene: str) -> PlanFile:
    """The scene's plan; it lacks only the seed."""
    plan = load_plan(scene.removesuffix(" pushed"))
    plant = plan.plant
    if scene.endswith("pushed"):
        plant = msgspec.structs.replace(plant, unmodelled=FORCE)
    trials = {name: plan.trials[name] for name in TRIALS}
    return msgspec.structs.replace(plan, trials=trials, plant=plant)


def work(job: tuple[str, int]) -> dict[str, Any]:
    """Verdict and reason of every term in one scene with one seed."""
    scene, seed = job
    vehicle = seatrial.load_vehicle("mallard-mp")
    trials = simulate(with_seed(plan_of(scene), seed), vehicle)
    record: dict[str, Any] = {"scene": scene, "seed": seed}
    try:
        found = select(
            [t.recording for t in trials], vehicle, candidates=given_candidates(vehicle, ABSENT)
        )
    except SeatrialError as failure:
        return record | {"failed": str(failure)}
    record["kept"] = [r.coefficient for r in found.rows if r.verdict.kept]
    record["weak"] = [r.coefficient for r in found.rows if r.reason.startswith("weak")]
    return record


def summary(records: list[dict[str, Any]]) -> Iterator[str]:
    """A line for each scene."""
    own = set(seatrial.load_vehicle("mallard-mp").structure.coefficients)
    yield (
        f"{'scene':<18} seeds  all true kept  without N_ud  absent kept: seeds, at most  "
        "N_ud weak  others weak or lost"
    )
    for scene in dict.fromkeys(r["scene"] for r in records):
        done = [r for r in records if r["scene"] == scene and "kept" in r]
        failed = sum(r["scene"] == scene for r in records) - len(done)
        n = max(1, len(done))
        lost = [own - set(r["kept"]) for r in done]
        extra = [len(set(r["kept"]) - own) for r in done]
        odd = Counter(name for r in done for name in r["weak"] if name != "N_ud")
        odd += Counter(f"-{name}" for gone in lost for name in gone if name != "N_ud")
        yield (
            f"{scene:<18} {len(done):>5}  {_share(sum(not x for x in lost), n):>13}  "
            f"{_share(sum(x <= {'N_ud'} for x in lost), n):>12}  "
            f"{_share(sum(x > 0 for x in extra), n):>18}, {max(extra, default=0):>7}  "
            f"{_share(sum('N_ud' in r['weak'] for r in done), n):>9}  "
            + (", ".join(f"{name} {count}" for name, count in odd.most_common()) or "none")
            + (f"; {failed} failed" if failed else "")
        )


def _share(count: int, of: int) -> str:
    return f"{100 * count / of:.1f} %"


def main() -> None:
    """Run what is not yet in the store, and print the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--store", type=Path, help="lines of JSON: goes on where it was stopped")
    args = parser.parse_args()
    stored = args.store is not None and args.store.exists()
    records = [json.loads(line) for line in args.store.open()] if stored else []
    done = {(r["scene"], r["seed"]) for r in records}
    jobs = [(s, i) for i in range(1, args.seeds + 1) for s in args.scenes.split(",")]
    with ProcessPoolExecutor(args.workers) as pool:
        for record in pool.map(work, [job for job in jobs if job not in done]):
            records.append(record)
            if args.store is not None:
                with args.store.open("a") as file:
                    file.write(json.dumps(record) + "\n")
            print(f"\r{len(records)}/{len(jobs)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    wanted = {*jobs}
    print("\n".join(summary([r for r in records if (r["scene"], r["seed"]) in wanted])))


if __name__ == "__main__":
    main()
