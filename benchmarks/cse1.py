# SPDX-License-Identifier: MIT
"""Gate: the real boat CSE1: prediction of the run that was left out, and drag against towing tests.

    python -m benchmarks.cse1
    python -m benchmarks.cse1 --vehicle data/cse1/pair.yaml --method output-error
    python -m benchmarks.cse1 --auto --no-ratios --method output-error --vehicle data/cse1/vehicle.yaml
    python -m benchmarks.cse1 --bollard    # what bollard.yaml states of the propellers

Velocities to compare with come from one Savitzky-Golay filter (Anal. Chem. 36, 1627, 1964), the
local cubic through 21 poses. It gives the starts, too, for the model and for "stays constant"
alike; so it does where the disturbance of the model's filter goes on and fades, the k-step
predictor with the noise model (Ljung, System Identification, section 3.2). Last, both start from
the past alone, a parabola through the last poses.
"""

import csv
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import seatrial
from benchmarks.harness import command
from seatrial.boat.schema import as_column
from seatrial.evaluation.filtering import run_filter
from seatrial.evaluation.prediction import Lookahead
from seatrial.identification.methods import METHODS
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import UNEVEN, Motion
from seatrial.util.frames import Array, body_velocity
from seatrial.util.statistics import NORMAL_95
from tests.boats.drives import RUNS, SHIP

CENTRED = (21, 3)  # poses and degree of the reference
PAST = (9, 2)  # of starts that know the past only
PROPELLERS = 2
POWER = "scale_power.propellers"
PAIR = ("pair_offset_across.propellers", "pair_dead_zone.propellers")


def local_polynomial(recording: Recording, width: int, degree: int, place: int) -> Motion:
    """Poses and velocities of the polynomial through `width` poses, at the `place`-th of them.

    Windows never reach over a masked pose, a gap or a jump.
    """
    n = len(recording.t)
    eta, nu, valid = recording.eta.copy(), np.full((n, 3), np.nan), np.zeros(n, dtype=bool)
    index = np.flatnonzero(recording.valid)
    windows = np.lib.stride_tricks.sliding_window_view(index, width)
    t = recording.t[windows]
    usable = np.diff(t, axis=1).max(axis=1) < UNEVEN * recording.period
    usable &= np.ptp(recording.segment[windows], axis=1) == 0
    windows, t = windows[usable], t[usable]
    powers = (t - t[:, place, None])[:, :, None] ** np.arange(degree + 1)
    fitted = np.linalg.pinv(powers)[:, :2] @ recording.eta[windows]  # value and slope (n, 2, 3)
    at = windows[:, place]
    eta[at], valid[at] = fitted[:, 0], True
    nu[at] = body_velocity(fitted[:, 0, 2], np.ascontiguousarray(fitted[:, 1]))
    return Motion(recording.t, eta, nu, valid)


def reference(recording: Recording) -> Motion:
    """The Savitzky-Golay filter's motion."""
    return local_polynomial(recording, *CENTRED, CENTRED[0] // 2)


def past(recording: Recording) -> Motion:
    """Motion known at its own time."""
    return local_polynomial(recording, *PAST, PAST[0] - 1)


def ratios(
    model: seatrial.Model,
    recording: Recording,
    start: Motion,
    truth: Motion,
    horizon: float,
    *,
    disturbed: bool = False,
) -> Array:
    """RMS error over that of a velocity that stays as it was at the start, for u, v, r."""
    filtered = run_filter(model, recording) if disturbed else None
    look = Lookahead(model, recording, start, filtered)
    ahead = look.predict(horizon, disturbed=disturbed)
    known = truth.valid[ahead.index]
    measured = truth.nu[ahead.index][known]
    wrong = np.sqrt(np.mean((measured - ahead.nu[known]) ** 2, axis=0))
    return np.asarray(wrong / np.sqrt(np.mean((measured - ahead.start[known]) ** 2, axis=0)))


def identified(
    recordings: Sequence[Recording], vehicle: seatrial.Vehicle, method: str
) -> seatrial.Model:
    """A model by a method; where it takes the actuators as known, as output-error finds them."""
    if vehicle.estimated and method == "equation-error":
        vehicle = seatrial.identify(recordings, vehicle, method="output-error").known_vehicle
    return seatrial.identify(recordings, vehicle, method=method)


def with_power(model: seatrial.Model, power: float) -> seatrial.Model:
    """The model with thrust proportional to this power of the propellers' speed."""
    constants = model.constants.copy()
    constants[list(model.vehicle.constants.names).index(POWER)] = power
    return replace(model, constants=constants)


def leave_one_out(
    runs: dict[str, Recording],
    vehicle: seatrial.Vehicle,
    method: str,
    horizon: float,
    power: float | None = None,
) -> None:
    """One line for every run, predicted by a model of the others, and their mean."""
    rows: list[list[Array]] = []
    for name, run in runs.items():
        others = [r for other, r in runs.items() if other != name]
        begin = time.perf_counter()
        try:
            model = identified(others, vehicle, method)
        except seatrial.SeatrialError as error:
            print(f"  {name:<14} refused: {str(error).partition('; ')[0]}")
            continue
        seconds = time.perf_counter() - begin
        model = model if power is None else with_power(model, power)
        truth = reference(run)
        found = [
            ratios(model, run, truth, truth, horizon),
            ratios(model, run, truth, truth, horizon, disturbed=True),
            ratios(model, run, past(run), truth, horizon),
        ]
        rows.append(found)
        print(f"  {name:<14} {_columns(found)}    {seconds:5.1f} s")
    if len(rows) == len(runs):
        print(f"  {'mean':<14} {_columns(np.mean(rows, axis=0))}")


def _columns(found: Iterable[Array]) -> str:
    """Numbers of u, v, r for each kind of prediction."""
    return "    ".join(" ".join(f"{x:5.3f}" for x in row) for row in found)


def towing(group: str) -> tuple[Array, Array]:
    """Abscissa (n,) and mean force [N] (n,) of a group of towing or bollard tests, rising."""
    with (SHIP / "tow_and_bollard_summary.csv").open(newline="") as file:
        rows = [r for r in csv.DictReader(file) if r["group"] == group]
    points = np.array([[float(r["value"]), float(r["force_N"])] for r in rows])
    points = points[np.argsort(points[:, 0], kind="stable")]
    return points[:, 0], points[:, 1]


def projected(regressors: Array, group: str, values: Array, inside: NDArray[np.bool_]) -> Array:
    """The tests' force at the values that occurred, as multiples of the model's own terms."""
    at, force = towing(group)
    inside = inside & (values >= at[0]) & (values <= at[-1])
    wanted = np.interp(values[inside], at, force)
    return np.asarray(np.linalg.lstsq(regressors[inside], wanted, rcond=None)[0])


def drag_and_thrust(model: seatrial.Model, runs: Sequence[Recording]) -> None:
    """Drag over thrust of the model and of the towing and bollard tests, term by term.

    Both tests are weighed as the recordings weigh them: towing force at the speeds, bollard force
    at the commands that occurred, fitted by the model's own terms and its own thruster curve with
    the others at rest, as in the tests.
    """
    speed = np.concatenate([m.nu[m.valid] for m in map(reference, runs)])
    command = np.concatenate([r.commands.values for r in runs])
    everywhere = np.ones(len(speed), dtype=bool)
    axes = model.vehicle.axes.signs  # the tests' are the file's
    chain, inputs = model.vehicle.chain, model.vehicle.inputs
    constants = np.array(model.constants)
    cases = [
        ("X_u", "X_uu", "X_F", 0, "SurgeDamping", "VSPsurge", "port_surge", PROPELLERS),
        ("Y_v", "Y_vv", "Y_F", 1, "SwayDamping", "VSPsway", "port_sway", PROPELLERS),
        ("Y_v", "Y_vv", "Y_b", 1, "SwayDamping", "BowThruster", "bow", 1),
    ]
    print("  ratio          model    95 % interval         tests")
    for linear, quadratic, gain, axis, drag, thrust, name, number in cases:
        if not {linear, quadratic, gain} <= set(model.values):
            continue
        v, k = np.ascontiguousarray(speed[:, axis] * axes[axis]), inputs.index(name)
        resisted = projected(np.column_stack([v, np.abs(v) * v]), drag, v, everywhere)
        c = command[:, k]
        alone = np.zeros_like(command)
        alone[:, k] = c
        g = seatrial._core.curve(chain, constants, k, alone)
        set_point = c * as_column(model.vehicle.file.commands.inputs[name]).scale
        pushed = number * float(projected(g[:, None], thrust, set_point, c != 0.0)[0])
        for term, newton in zip((linear, quadratic), resisted, strict=True):
            show(model, {term: 1.0}, gain, newton / pushed, f"{term}/{gain}")
        typical = float(np.sqrt(np.mean(v**2)))  # [m/s]
        both = {linear: 1.0, quadratic: typical}
        total = float(resisted @ [1.0, typical]) / pushed
        show(model, both, gain, total, f"{linear}+{typical:.2f}{quadratic}")


def show(
    model: seatrial.Model, drag: dict[str, float], gain: str, truth: float, label: str
) -> None:
    """One line: a sum of drag coefficients over a gain, with its interval."""
    names = list(model.parameters)
    value = model.values[gain]
    ratio = sum(weight * model.values[n] for n, weight in drag.items()) / value
    slope = np.zeros(len(names))
    slope[names.index(gain)] = -ratio / value
    for name, weight in drag.items():
        slope[names.index(name)] += weight / value
    spread = NORMAL_95 * float(np.sqrt(slope @ model.covariance @ slope))
    print(
        f"  {label:<12} {ratio:8.2f}   {ratio - spread:6.2f} ... {ratio + spread:6.2f}  {truth:10.2f}"
    )


def pair_by_pulls() -> tuple[Array, Array, int]:
    """A pair's offset across and dead zone by least squares on the pulls along and across.

    Values (2,), their errors (2,), and the number of pulls.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 a tenth of a second

    vehicle = seatrial.load_vehicle(SHIP / "pair.yaml")
    pulls = [("port_surge", *towing("VSPsurge")), ("port_sway", *towing("VSPsway"))]
    scale = {k: as_column(i).scale for k, i in vehicle.file.commands.inputs.items()}

    def left(x: Array) -> Array:
        known = vehicle.with_stated(dict(zip(PAIR, x[:2].tolist(), strict=True)))
        found = []
        for (name, set_point, force), newton in zip(pulls, x[2:].tolist(), strict=True):
            k = vehicle.inputs.index(name)
            rows = np.zeros((len(force), len(vehicle.inputs)))
            rows[:, k] = set_point / scale[name]
            curve = seatrial._core.curve(known.chain, known.constants.values, k, rows)
            found.append(newton * curve - force)
        return np.concatenate(found)

    best = least_squares(left, [0.1, 0.2, 1.0, 1.0], diff_step=1e-3)
    variance = 2.0 * best.cost / (len(best.fun) - len(best.x))
    errors = np.sqrt(variance * np.diag(np.linalg.inv(best.jac.T @ best.jac)))
    return best.x[:2], errors[:2], len(best.fun)


def main(arguments: Sequence[str]) -> None:
    """Read what is to be compared, and print."""
    parser = command.parser("cse1", __doc__)
    default = [SHIP / n for n in ("bollard.yaml", "pair.yaml", "coupled.yaml", "vehicle.yaml")]
    parser.add_argument("--vehicle", type=Path, action="append", help="vehicle file; repeat")
    parser.add_argument("--method", action="append", choices=METHODS, help="repeat; all")
    parser.add_argument("--horizon", type=float, default=1.0, help="[s]")
    parser.add_argument("--power", type=float, help="exponent of the propellers' speed in thrust")
    parser.add_argument("--no-ratios", action="store_true", help="leave out drag over thrust")
    parser.add_argument("--auto", action="store_true", help="with structure: auto")
    parser.add_argument("--bollard", action="store_true", help="the pair by the bollard pulls")
    chosen = parser.parse_args(arguments)
    if chosen.bollard:
        values, errors, pulls = pair_by_pulls()
        for name, value, error in zip(PAIR, values, errors, strict=True):
            print(f"{name} {value:.3f} ± {error:.3f}, by {pulls} pulls")
        return
    for path in chosen.vehicle or default:
        vehicle = seatrial.load_vehicle(path)
        paths = {name: SHIP / "csv" / f"CSE1_data_{name}.csv" for name in RUNS}
        runs = {name: seatrial.read(source, vehicle) for name, source in paths.items()}
        vehicle = vehicle.with_automatic_structure() if chosen.auto else vehicle
        for method in chosen.method or METHODS:
            print(f"{path.name}, {method}: error {chosen.horizon:g} s ahead / stays constant")
            print(
                "  left out       starts: smoothed     and disturbance      past only            fit in"
            )
            print("                 u     v     r    " + "    u     v     r    " * 2)
            leave_one_out(runs, vehicle, method, chosen.horizon, chosen.power)
            if not chosen.no_ratios:
                model = identified(list(runs.values()), vehicle, method)
                drag_and_thrust(model, list(runs.values()))


if __name__ == "__main__":
    main(sys.argv[1:])
