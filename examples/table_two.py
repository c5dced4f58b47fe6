# SPDX-License-Identifier: MIT
"""Table II of the paper, from noiseless single-axis trials by its own recursion: all 11 come back.

Forward Euler at 15 Hz, true velocities, no actuator chain. Usage: python examples/table_two.py
"""

from dataclasses import replace

import numpy as np

import seatrial
from seatrial import _core
from seatrial.boat.schema import Integration
from seatrial.identification.methods import EquationErrorSettings
from seatrial.identification.regression.equation_error import equation_error
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model

RATE = 15.0  # [Hz]
SECONDS = 60
AF = load_plan("clean").plant.coefficients
MP = {
    "X_u": -0.10, "X_uu": -1.67, "X_F": 0.15, "Y_v": -0.23, "Y_vv": -1.26, "Y_F": 0.26,
    "N_r": -0.73, "N_rr": -0.30, "N_F": 1.39, "N_ud": -0.14, "N_uu": 1.07,
}  # fmt: skip


def trial(model: seatrial.Model, axis: int) -> tuple[seatrial.Recording, seatrial.Motion]:
    """A minute of pulses in one axis, and the true velocities."""
    n = int(RATE * SECONDS)
    stamps = np.rint(np.arange(n) / RATE * 1e9).astype(np.int64)
    sticks = np.zeros((n, 3))
    pulses = np.random.default_rng(axis).uniform(-1, 1, n // 10 + 1)
    sticks[:, axis] = np.repeat(pulses, 10)[:n]
    commands = Signal(("F_u", "F_v", "F_r"), stamps, sticks)
    blank = make_recording("blank", stamps, np.zeros((n, 3)), commands)
    x, _ = _core.simulate(model.boat, model.trace(blank), np.zeros(6), blank.t)
    record = make_recording(f"S{axis + 1}", stamps, x[:, :3], commands)
    return record, seatrial.Motion(record.t, x[:, :3], x[:, 3:], np.ones(n, dtype=bool))


def identified(column: dict[str, float], settings: EquationErrorSettings) -> seatrial.Model:
    """The column's boat, driven and identified again."""
    vehicle = seatrial.load_vehicle("mallard-mp")
    plan = load_plan("clean")
    truth = plant_model(plan, vehicle)
    values = np.array([column[name] for name in truth.structure.coefficients])
    bare = replace(
        truth, vehicle=vehicle, constants=np.zeros(0), coefficients=values,
        covariance=np.zeros((len(values), len(values))), integration=Integration("forward-euler", 1 / RATE),
    )  # fmt: skip
    data = [trial(bare, axis) for axis in range(3)]
    return equation_error(
        [r for r, _ in data], vehicle, settings=settings, motions=[m for _, m in data]
    )


def main() -> None:
    """Print truth, what comes back, and what Eq. (17) gives when taken literally."""
    print("         MP: true  found - true   Eq. (17) literal   AF: true  found - true   literal")
    found = [identified(c, EquationErrorSettings()) for c in (MP, AF)]
    literal = [identified(c, EquationErrorSettings(literal=True)) for c in (MP, AF)]
    for name in found[0].values:
        cells = [
            f"{true[name]:8.2f}  {exact.values[name] - true[name]:12.1e}  {printed.values[name]:10.4f}"
            for true, exact, printed in zip((MP, AF), found, literal, strict=True)
        ]
        print(f"{name:<5}  " + "        ".join(cells))


if __name__ == "__main__":
    main()
