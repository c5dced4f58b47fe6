# SPDX-License-Identifier: MIT
"""seatrial as a library: read, identify, predict, validate. Usage: python examples/library.py"""

from pathlib import Path

import seatrial

SHIP = Path(__file__).resolve().parents[1] / "data" / "cse1"

vehicle = seatrial.load_vehicle(SHIP / "coupled.yaml")
runs = [
    seatrial.read(SHIP / "csv" / f"CSE1_data_{name}.csv", vehicle)
    for name in ("random_run1", "random_run3", "run1")
]
with seatrial.show_progress():  # a line on the terminal; or a function of your own gets the status
    # by the paper's method, in a second; without `method` by output-error, in a minute
    model = seatrial.identify(runs[:2], vehicle, method="equation-error")
for name, value in model.values.items():
    print(
        f"{name:<5} {value:8.4f} ± {model.standard_errors[name]:.4f} {model.structure.units[name]}"
    )

ahead = seatrial.predict(model, runs[2], horizon=1.0)
print(f"{len(ahead.t)} predictions; the first, for t = {ahead.t[0]:.2f} s: {ahead.nu[0].round(4)}")

scores = seatrial.validate(model, [runs[2]])
for symbol, score in scores.recordings[0].scores.items():
    print(f"{symbol}: RMS {score.rms:.4f}, {score.ratio:.2f} of 'velocity stays constant'")
