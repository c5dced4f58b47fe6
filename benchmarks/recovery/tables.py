# SPDX-License-Identifier: MIT
"""The results as markdown tables, each figure beside its limit."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.harness.markdown import table
from benchmarks.harness.store import Record
from seatrial.util.frames import SYMBOLS, Array
from seatrial.util.statistics import NORMAL_95
from tests.boats.scenes import ALLOCATIONS, PRESETS

LIMIT = {"still": 1.25, "pushed": 1.4}  # RMS error over bound
BOUND = {"still": "whole", "pushed": "process"}
EDGE_LIMIT, DELAY_LIMIT = 0.01, 0.005  # [-], [s]
AHEAD_LIMIT = {
    "true": dict.fromkeys(PRESETS, 8.0),
    "own": dict(zip(PRESETS, (4.0, 6.0), strict=True)),
}
OWN = {"ours": "ours filter", "paper": "paper stencil"}


def good(records: Sequence[Record], scene: str) -> list[Record]:
    """A scene's results in which a model was found, of the parameters that all of them have.

    A stage of the curve is freed where a seed's noise makes it look worth it.
    """
    found = [r for r in records if r["scene"] == scene and "failed" not in r]
    every = set.intersection(*(set(r["names"]) for r in found)) if found else set()
    return [_only(r, every) for r in found]


def _only(record: Record, names: set[str]) -> Record:
    """A record of these parameters."""
    places = [i for i, name in enumerate(record["names"]) if name in names]

    def kept(values: Sequence[Any]) -> list[Any]:
        return [values[i] for i in places]

    cut = {key: kept(record[key]) for key in ("names", "truth", "found", "error")}
    if "bound" in record:
        cut["bound"] = {name: kept(values) for name, values in record["bound"].items()}
    return record | cut


def stack(records: Sequence[Record], key: str, size: int | None = None) -> Array:
    """(seeds, parameters), or the first `size` of them."""
    return np.array([r[key][:size] for r in records])


def rms(errors: Array) -> Array:
    """Over seeds."""
    return np.asarray(np.sqrt(np.mean(errors**2, axis=0)))


def bound(records: Sequence[Record], name: str) -> Array:
    """Standard deviations of the best possible estimator over these seeds."""
    return np.asarray(np.sqrt(np.mean([r["bound"][name] for r in records], axis=0)))


def inside(records: Sequence[Record]) -> Array:
    """(seeds, parameters) whether the 95 % interval holds the truth."""
    off = np.abs(stack(records, "found") - stack(records, "truth"))
    return np.asarray(off <= NORMAL_95 * stack(records, "error"))


def recovery(records: Sequence[Record], scene: str) -> str:
    """Errors, bounds and coverage of one scene, parameter by parameter."""
    mine = good(records, scene)
    group = mine[0]["group"]
    best = BOUND[group]
    error = rms(stack(mine, "found") - stack(mine, "truth"))
    limits = {name: bound(mine, name) for name in mine[0]["bound"]}
    covered, ratio = inside(mine).mean(axis=0), error / limits[best]
    others = [name for name in limits if name != best]
    stated = np.median(stack(mine, "error"), axis=0)
    rows = [
        [
            name, f"{mine[0]['truth'][i]:.4g}", f"{error[i]:.2g}", f"{limits[best][i]:.2g}",
            f"{ratio[i]:.2f}", f"{stated[i]:.2g}", f"{100 * covered[i]:.1f}",
            *(f"{limits[name][i]:.2g}" for name in others),
        ]
        for i, name in enumerate(mine[0]["names"])
    ]  # fmt: skip
    head = [
        "", "truth", "RMS error", f"bound ({best})", "ratio", "stated error", "coverage, %",
        *(f"bound ({name})" for name in others),
    ]  # fmt: skip
    return f"### {scene}, {len(mine)} seeds\n\n{table(head, rows)}"


def overview(records: Sequence[Record], names: Sequence[str]) -> str:
    """One row a scene: the worst ratio and the coverage of the coefficients, failures, time."""
    rows = []
    for scene in names:
        mine = good(records, scene)
        failed = sum(r["scene"] == scene for r in records) - len(mine)
        if not mine:
            continue
        off = rms(stack(mine, "found") - stack(mine, "truth"))
        ratio = off / bound(mine, BOUND[mine[0]["group"]])
        covered, size = inside(mine), _coefficients(mine[0])
        each, parameters = covered.mean(axis=0), mine[0]["names"]
        worst, low, high = int(ratio.argmax()), int(each.argmin()), int(each.argmax())
        rows.append([
            scene, f"{len(mine)}", f"{failed}", f"{ratio[worst]:.2f} ({parameters[worst]})",
            f"{LIMIT[mine[0]['group']]}", f"{rms(ratio):.2f}", f"{100 * covered.mean():.1f}",
            f"{100 * covered[:, :size].mean():.1f}", f"{100 * each[low]:.0f} ({parameters[low]})",
            f"{100 * each[high]:.0f}",
        ])  # fmt: skip
    head = [
        "scene", "seeds", "failed", "largest RMS / bound", "limit", "all, RMS",
        "coverage, %", "of coefficients", "lowest", "highest",
    ]  # fmt: skip
    return table(head, rows)


def _coefficients(record: Record) -> int:
    """How many of the parameters are coefficients."""
    first = ("latency", "lag", "edge_forward", "edge_reverse")
    return min(i for i, name in enumerate(record["names"]) if name.partition(".")[0] in first)


def noise_levels(records: Sequence[Record], names: Sequence[str]) -> str:
    """Estimated noise: median over seeds."""
    rows = []
    for scene in names:
        mine = good(records, scene)
        if mine:
            level, process = (np.median(stack(mine, k), axis=0) for k in ("noise", "process"))
            rows.append([
                scene, f"{1e3 * level[0]:.3g}", f"{1e3 * level[1]:.3g}",
                *(f"{value:.2g}" for value in process),
            ])  # fmt: skip
    head = [
        "scene", "position, mm", "heading, mrad", "walk, m/s/√s", "walk, rad/s/√s",
        "disturbance, m/s²", "disturbance, rad/s²", "memory, s",
        "correlated, m", "rad", "memory, s", "swing, rad/s",
    ]  # fmt: skip
    return table(head, rows)


def thrusters(records: Sequence[Record], names: Sequence[str]) -> str:
    """Dead zone and delays."""
    rows = []
    for scene in names:
        mine = good(records, scene)
        if not mine:
            continue
        off = stack(mine, "found") - stack(mine, "truth")
        place = {name: i for i, name in enumerate(mine[0]["names"])}
        edges = off[:, [i for name, i in place.items() if name.startswith("edge")]]
        delay = off[:, place["latency"]] + off[:, place["lag"]]
        zone = [f"{rms(edges.ravel()):.2g}", f"{np.abs(edges).max():.2g}"] if edges.size else []
        rows.append([
            scene, *(zone or ["not identifiable", "-"]), f"{EDGE_LIMIT}",
            f"{1e3 * rms(delay):.2f}", f"{1e3 * np.abs(delay).max():.2f}", f"{1e3 * DELAY_LIMIT:g}",
            f"{1e3 * rms(off[:, place['latency']]):.2f}", f"{1e3 * rms(off[:, place['lag']]):.2f}",
        ])  # fmt: skip
    head = [
        "scene", "dead zone: RMS", "largest", "limit", "lag + latency, ms: RMS", "largest", "limit",
        "latency alone: RMS", "lag alone: RMS",
    ]  # fmt: skip
    return table(head, rows)


def prediction(records: Sequence[Record], drive: str = "") -> str:
    """S7, 1 s ahead against the true velocity: RMS over seeds, and how many times lower it is."""
    rows, found = [], {}
    for preset in PRESETS:
        for allocation in ALLOCATIONS:
            mine = good(records, f"{preset} {allocation}{drive}")
            if not mine:
                continue
            level = {k: rms(np.array([r["ahead"][k] for r in mine])) for k in mine[0]["ahead"]}
            found[preset, allocation] = level
            for axis, symbol in enumerate(SYMBOLS):
                true = level["paper true"][axis] / level["ours true"][axis]
                own = level[OWN["paper"]][axis] / level[OWN["ours"]][axis]
                rows.append([
                    f"{preset} {allocation} {symbol}",
                    *(f"{level[k][axis]:.2g}" for k in level),
                    f"{true:.0f}", f"{AHEAD_LIMIT['true'][preset]:g}",
                    f"{own:.0f}", f"{AHEAD_LIMIT['own'][preset]:g}",
                ])  # fmt: skip
    if not rows:
        return ""
    keys = [k.replace(" ", ", ") for k in next(iter(found.values()))]
    head = ["m/s, rad/s", *keys, "true starts: times lower", "at least", "own starts", "at least"]
    return table(head, rows) + "\n" + _allocations(found)


def _allocations(found: dict[tuple[str, str], dict[str, Array]]) -> str:
    rows = []
    for preset in PRESETS:
        if all((preset, a) in found for a in ALLOCATIONS):
            ours = [found[preset, a] for a in ALLOCATIONS]
            for key in ("ours true", OWN["ours"]):
                cells = [f"{x:.2f}" for x in ours[0][key] / ours[1][key]]
                rows.append([f"{preset}, {key.replace(' ', ', ')}", *cells, "1.2"])
    return table(["MP / AF", *SYMBOLS, "at most"], rows)


def fault_moves(records: Sequence[Record], names: Sequence[str]) -> str:
    """How far jumps and drop-outs move each coefficient, in standard errors."""
    rows = []
    for scene in names:
        mine = good(records, scene)
        if not mine:
            continue
        size = _coefficients(mine[0])
        found, without, missing, truth, error = (
            stack(mine, key, size) for key in ("found", "without", "missing", "truth", "error")
        )
        ratio, best = np.abs(found - without) / error, np.abs(missing - without) / error
        off, before = rms(found - truth), rms(without - truth)
        rows.append([
            scene, f"{len(mine)}", f"{ratio.max():.2f}", f"{100 * (ratio > 1).mean():.1f}",
            f"{rms(ratio.ravel()):.2f}", f"{best.max():.2f}", f"{100 * (best > 1).mean():.1f}",
            f"{rms(best.ravel()):.2f}",
            f"{np.median(off / before):.2f}", f"{100 * inside(mine)[:, :size].mean():.1f}",
        ])  # fmt: skip
    head = [
        "scene", "seeds", "largest move / standard error", "share above 1, %", "RMS",
        "known and left out: largest", "share above 1, %", "RMS", "RMS error, with / without",
        "coverage, %",
    ]  # fmt: skip
    return table(head, rows)


def further(records: Sequence[Record], names: Sequence[str]) -> str:
    """Seeds that freed parameters which not all seeds of their scene have; these are in no other table."""
    rows = []
    for scene in names:
        found = [r for r in records if r["scene"] == scene and "failed" not in r]
        for record, common in zip(found, good(records, scene), strict=True):
            more = [n for n in record["names"] if n not in common["names"]]
            if not more:
                continue
            off = _far(common)[: _coefficients(common)]
            most = int(np.argmax(np.abs(off)))
            more_values = (
                f"{name} {value:.2f} ± {error:.2f}"
                for name, value, error in zip(
                    *(record[k] for k in ("names", "found", "error")), strict=True
                )
                if name in more
            )
            rows.append([scene, f"{record['seed']}", ", ".join(more_values),
                         f"{off[most]:.1f} ({common['names'][most]})"])  # fmt: skip
    return table(
        ["scene", "seed", "freed parameters", "largest error of a coefficient / standard error"],
        rows,
    )


def _far(record: Record) -> Array:
    """(parameters,) how far each is from the truth, in standard errors."""
    found, truth, error = (np.array(record[k]) for k in ("found", "truth", "error"))
    return np.asarray((found - truth) / error)


def failures(records: Sequence[Record]) -> str:
    """What raised."""
    return "".join(
        f"- {r['scene']}, seed {r['seed']}: {r['failed']}\n" for r in records if "failed" in r
    )
