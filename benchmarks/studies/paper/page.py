# SPDX-License-Identifier: MIT
"""The tables and figures of docs/paper.md, between marks in it."""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial, reduce
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.markdown import table
from benchmarks.harness.page import fill
from benchmarks.studies.paper import cost, coupling, maps, minutes, open_points, payload, tables
from benchmarks.studies.paper.grid import Grid, draw
from seatrial.util.frames import Array
from tests.boats.scenes import ALLOCATIONS

PAPER, OURS = maps.METHODS
MEASURED_RATIOS = (1.28, 1.59, 1.43)  # the paper's Table III, MP / AF
Found = Mapping[tuple[Any, ...], list[dict[str, Any]]]


def write(records: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Replace every block between `<!-- name -->` and `<!-- end -->`; figures beside the page."""
    fill(path, {name: partial(made, records) for name, made in BLOCKS.items()})
    folder = path.parent / "images"
    for method, name in ((PAPER, "map-paper"), (OURS, "map-ours")):
        draw(ratio_grids(records, method), folder / f"{name}.svg")


def of(records: Sequence[Mapping[str, Any]], finding: str) -> Found:
    """Results over the seeds by key without the seed, which is its last entry."""
    out: dict[tuple[Any, ...], list[dict[str, Any]]] = defaultdict(list)
    for record in records:
        if record["finding"] == finding:
            out[tuple(record["key"][:-1])].append(record["found"])
    return out


def mean(found: Sequence[Mapping[str, Any]], *path: str) -> Array:
    """Over the seeds of what lies under these names."""
    return np.asarray(np.mean([reduce(getitem, path, one) for one in found], axis=0))


def table_two(records: Sequence[Mapping[str, Any]]) -> str:
    """Coefficients by the paper's method: printed, and from simulated trials."""
    found = of(records, "tables")
    head = ["", *(f"paper, {a}" for a in ALLOCATIONS)]
    head += [f"{plan}, {a}" for plan in tables.PLANS for a in ALLOCATIONS] + ["truth"]
    rows = []
    for name, printed in tables.PRINTED.items():
        row = [name, *(f"{v:g}" for v in printed)]
        for plan in tables.PLANS:
            for a in ALLOCATIONS:
                values = [f[PAPER]["coefficients"][name] for f in found[plan, a]]
                row.append(f"{np.mean(values):.2f} ± {np.std(values):.2f}")
        rows.append([*row, f"{printed[1]:g}"])
    return table(head, rows)


def table_three(records: Sequence[Mapping[str, Any]]) -> str:
    """RMS errors 1 s ahead by the paper's pairing."""
    found = of(records, "tables")
    rows = [_errors("the paper", [np.array(tables.PRINTED_ERRORS[a]) for a in ALLOCATIONS])]
    for plan in tables.PLANS:
        for method in maps.METHODS:
            errors = [mean(found[plan, a], method, "paired") for a in ALLOCATIONS]
            rows.append(_errors(f"{plan}, {method}", errors))
    head = ["RMS 1 s ahead, MP / AF", "S4 u, cm/s", "S5 v, cm/s", "S6 r, rad/s", "ratios u, v, r"]
    return table(head, rows)


def _errors(name: str, both: Sequence[Array]) -> list[str]:
    scale = np.array([100.0, 100.0, 1.0])
    mp, af = both[0] * scale, both[1] * scale
    cells = [f"{a:.3g} / {b:.3g}" for a, b in zip(mp, af, strict=True)]
    return [name, *cells, ", ".join(f"{r:.2f}" for r in mp / af)]


def unseen(records: Sequence[Mapping[str, Any]]) -> str:
    """S7: errors, shape of the histograms, what is left of the autocorrelation."""
    found = of(records, "tables")
    rows = []
    for plan in tables.PLANS:
        for method in maps.METHODS:
            for a in ALLOCATIONS:
                mine = found[plan, a]
                errors = mean(mine, method, "unseen") * [100.0, 100.0, 1.0]
                floor = mean(mine, method, "floor") * [100.0, 100.0, 1.0]
                left = np.mean(
                    [
                        [tables.beyond(r, f[method]["steps"]) for r in f[method]["rho"]]
                        for f in mine
                    ],
                    axis=0,
                )
                rows.append([
                    f"{plan}, {method}, {a}", ", ".join(f"{e:.3g}" for e in errors),
                    ", ".join(f"{e:.3g}" for e in floor),
                    ", ".join(f"{k:.2f}" for k in mean(mine, method, "kurtosis")),
                    _joined(left, 2),
                ])  # fmt: skip
    head = ["S7, 1 s ahead: u, v, r", "RMS, cm/s and rad/s", "floor", "kurtosis"]
    head.append("autocorrelation beyond 1 s, RMS")
    return table(head, rows)


def both_found(found: Found, method: str, key: tuple[Any, ...]) -> list[tuple[Any, Any]]:
    """MP and AF of every seed in which the method found a model of both."""
    mp, af = (found.get((*key, a), []) for a in ALLOCATIONS)
    pairs = zip(mp, af, strict=False)
    return [(m[method], a[method]) for m, a in pairs if m[method] and a[method]]


def ratio(found: Found, method: str, key: tuple[Any, ...]) -> Array:
    """MP over AF by the pairing (3,), geometric mean over the seeds; NaN where there is none."""
    pairs = both_found(found, method, key)
    if not pairs:
        return np.full(3, np.nan)
    logs = [np.log(np.array(m["paired"]) / np.array(a["paired"])) for m, a in pairs]
    return np.asarray(np.exp(np.mean(logs, axis=0)))


def ratio_grids(records: Sequence[Mapping[str, Any]], method: str) -> list[Grid]:
    """A grid for each noise: dead zone by size of the commands."""
    found, rows = of(records, "maps"), [f"{edge:g}" for edge in maps.EDGES]
    out = []
    for noise in maps.NOISES:
        cells = [
            [_middle(ratio(found, method, (edge, size, noise))) for size in maps.AMPLITUDES]
            for edge in maps.EDGES
        ]
        out.append(Grid(f"pose noise {noise}", rows, list(maps.AMPLITUDES), cells))
    return out


def _middle(ratios: Array) -> float:
    """Geometric mean."""
    return float(np.exp(np.mean(np.log(ratios))))


def nearest(records: Sequence[Mapping[str, Any]]) -> str:
    """Where on the map the paper's ratios, and its levels, are."""
    levels = np.log(np.array([tables.PRINTED_ERRORS[a] for a in ALLOCATIONS]))
    cells = []
    found = of(records, "maps")
    for noise in maps.NOISES:
        for size in maps.AMPLITUDES:
            for edge in maps.EDGES:
                key = (edge, size, noise)
                pairs = both_found(found, PAPER, key)
                if not pairs:
                    continue
                both = np.mean([[m["paired"], a["paired"]] for m, a in pairs], axis=0)
                off = [np.log(ratio(found, PAPER, key) / MEASURED_RATIOS), np.log(both) - levels]
                cells.append((key, *(float(np.sqrt(np.mean(o**2))) for o in off), both))
    rows = []
    for what, at in (("ratios", 1), ("levels", 2)):
        for cell in sorted(cells, key=lambda c: c[at])[:3]:
            (edge, size, noise), both = cell[0], cell[3] * [100.0, 100.0, 1.0]
            rows.append([
                f"nearest in {what}", f"{edge:g}", size, noise, f"{100 * (np.exp(cell[at]) - 1):.0f} %",
                ", ".join(f"{m:.3g} / {a:.3g}" for m, a in zip(*both, strict=True)),
                ", ".join(f"{r:.2f}" for r in both[0] / both[1]),
            ])  # fmt: skip
    return table(
        [
            "",
            "dead zone",
            "commands",
            "pose noise",
            "off by",
            "MP / AF: u, v cm/s, r rad/s",
            "ratios",
        ],
        rows,
    )


def identified(records: Sequence[Mapping[str, Any]]) -> str:
    """MP over AF on S7 against the true velocity, dead zone identified, and the gain over the paper."""
    found = of(records, "maps")
    rows = []
    for noise in maps.NOISES:
        for edge in maps.EDGES:
            errors = {}
            for m in maps.METHODS:
                pairs = [
                    pair
                    for size in maps.AMPLITUDES
                    for pair in both_found(found, m, (edge, size, noise))
                ]
                if pairs:
                    logs = [np.log(np.array([p["true"], a["true"]])) for p, a in pairs]
                    errors[m] = np.exp(np.mean(logs, axis=0))
            row = [f"{noise}, dead zone {edge:g}"]
            row += [
                _joined(errors[m][0] / errors[m][1], 2) if m in errors else "-"
                for m in maps.METHODS
            ]
            for i in range(len(ALLOCATIONS)):
                full = len(errors) == len(maps.METHODS)
                row.append(_joined(errors[PAPER][i] / errors[OURS][i], 0) if full else "-")
            rows.append(row)
    head = ["S7, true velocity: u, v, r", *(f"MP / AF, {m}" for m in maps.METHODS)]
    return table([*head, *(f"the paper's / ours, {a}" for a in ALLOCATIONS)], rows)


def _joined(values: Array, digits: int) -> str:
    return ", ".join(f"{v:.{digits}f}" for v in values)


def driven(records: Sequence[Mapping[str, Any]]) -> str:
    """Errors on S7 against minutes, pool and rate."""
    found = of(records, "minutes")
    rows = []
    for key in sorted(found, key=lambda k: (k[1] != minutes.USUAL[1], k[2] != minutes.USUAL[2], k)):
        seconds, pool, rate = key
        cells = []
        for method in minutes.METHODS:
            good = [f[method] for f in found[key] if f[method] is not None]
            refused = len(found[key]) - len(good)
            value = np.mean(good, axis=0) * [100.0, 100.0, 1.0] if good else None
            cell = "refused" if value is None else ", ".join(f"{v:.2g}" for v in value)
            cells.append(
                cell + (f" ({refused} of {len(found[key])} refused)" if refused and good else "")
            )
        rows.append([f"3 x {seconds:g} s", pool, f"{rate:g}", *cells])
    return table(
        ["driven", "pool", "poses, Hz", *(f"{m}: u, v cm/s, r rad/s" for m in minutes.METHODS)],
        rows,
    )


def coupled(records: Sequence[Mapping[str, Any]]) -> str:
    """Heading after push and drift: error of each model."""
    found = of(records, "coupling")
    rows = []
    for plan in coupling.PLANS:
        truth = np.array([f["truth"] for f in found[plan,]])
        rows.append([f"{plan}: true boat", *_degrees(truth.mean(axis=0))])
        for name in coupling.LEFT_OUT:
            off = np.array([f[name] for f in found[plan,]]) - truth
            rows.append([f"{plan}: error, {name}", *_degrees(np.sqrt(np.mean(off**2, axis=0)))])
    head = [
        "heading after push / after drift, deg",
        *(f"F_u {level:g}" for level in coupling.LEVELS),
    ]
    return table(head, rows)


def _degrees(values: Array) -> list[str]:
    return [f"{a:.2g} / {b:.2g}" for a, b in values]


def left_open(records: Sequence[Mapping[str, Any]]) -> str:
    """Eq. (17) both ways; score and floor of the true model; share of lags beyond the white band."""
    found = of(records, "open")
    rows = []
    for plan in open_points.PLANS:
        for a in ALLOCATIONS:
            mine = found[plan, a]
            pairs = [
                ", ".join(f"{v:.2f}" for v in mean(mine, kind))
                for kind in ("simultaneous", "literal")
            ]
            shares = [
                ", ".join(f"{100 * v:.0f}" for v in mean(mine, kind))
                for kind in ("white", "beyond")
            ]
            over = mean(mine, "rms") / mean(mine, "floor")
            rows.append([f"{plan}, {a}", *pairs, ", ".join(f"{v:.3f}" for v in over), *shares])
    head = [
        "",
        "N_ud, N_uu simultaneous",
        "literal",
        "true model: RMS / floor",
        "lags outside the white band below 1 s, %",
        "beyond, %",
    ]
    return table(head, rows)


def payload_found(records: Sequence[Mapping[str, Any]]) -> str:
    """Over the length of S7: thrust over the old model's with the prior; found changed alone."""
    found = of_kind(records)
    rows = []
    for kind, mine in found.items():
        for seconds in payload.SECONDS:
            each = [one[f"{seconds:g}"] for one in mine]
            factors = np.array([e["factors"] for e in each if "factors" in e])
            alone = [e["changed"] for e in each if "changed" in e]
            share = (
                f"{100 * np.mean(alone):.0f} % of {len(alone)}" if alone else "refused: too short"
            )
            rows.append([
                kind, f"{seconds:g}", f"{len(factors)}",
                ", ".join(f"{m:.3f} ± {s:.3f}" for m, s in zip(factors.mean(0), factors.std(0), strict=True)),
                share,
            ])  # fmt: skip
    head = [
        "hard", "S7, s", "boats", "X_F, Y_F, N_F over the old, with the prior (0.833 is right)",
        "alone: boat found changed",
    ]  # fmt: skip
    return table(head, rows)


def of_kind(records: Sequence[Mapping[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """Results on the payload by kind of recording."""
    out: dict[str, list[dict[str, Any]]] = {kind: [] for kind in payload.KINDS}
    for record in records:
        if record["finding"] == "payload":
            out[record["key"][0]].append(record["found"])
    return {kind: found for kind, found in out.items() if found}


BLOCKS: dict[str, Callable[[Sequence[Mapping[str, Any]]], str]] = {
    "table-two": table_two, "table-three": table_three, "unseen": unseen, "nearest": nearest,
    "identified": identified, "driven": driven, "coupled": coupled, "left-open": left_open,
    "payload": payload_found,
    "cost": lambda _: cost.page_table(),
}  # fmt: skip
