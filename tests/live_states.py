# SPDX-License-Identifier: MIT
"""A session that is not one: its states are set by the test, its buttons are noted."""

import time

import numpy as np
from msgspec.structs import replace

from seatrial.poolside.state import (
    CoverageState,
    LiveState,
    ManoeuvreState,
    ParameterState,
    PredictionState,
    SignalState,
    UseState,
)
from seatrial.util.errors import LiveError

NAMES = ("X_u", "X_uu", "Y_v", "N_r", "thrust_lag")
WALLS = ((-1.5, -2.5), (1.5, -2.5), (1.5, 2.5), (-1.5, 2.5))


def shown_state(t: float = 42.0) -> LiveState:
    """A state with everything on it, after `t` [s]."""
    ahead = np.linspace(0.0, 12.0, 25)
    times = tuple(np.linspace(max(t - 60.0, 0.0), t, 300))
    speed = tuple(0.3 * np.sin(times))
    return LiveState(
        vehicle="model ship",
        inputs=("F_u", "F_r"),
        source="udp:7001",
        folder="pool-1",
        time=t,
        driven=0.9 * t,
        poses=int(50 * t),
        pose=(0.4, -0.8, 0.6),
        walls=WALLS,
        signals=(
            SignalState(
                "pose", "pose", int(50 * t), 49.8, 0.02, 0.031, 0.004, value=(0.4, -0.8, 0.6)
            ),
            SignalState(
                "F_r",
                "command",
                int(100 * t),
                99.0,
                0.01,
                value=(0.3,),
                level="warning",
                gaps=2,
                finding="The boat turns to the other side than F_r states.",
                edit="F_r: {column: rudder, sign: -1}",
            ),
        ),
        parameters=tuple(
            ParameterState(name, "1/s", -0.31 * (k + 1), 0.4 / (k + 1) / t, 0.01, k > 2)
            for k, name in enumerate(NAMES)
        ),
        predictions=tuple(
            PredictionState(axis, 0.012, 0.010, 0.05, times, speed, tuple(0.98 * x for x in speed))
            for axis in ("surge", "sway", "yaw")
        ),
        coverage=tuple(
            CoverageState(
                axis,
                (-0.4, -0.2, 0.0, 0.2, 0.4),
                (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0),
                tuple(tuple(float(i * j) for j in range(5)) for i in range(4)),
            )
            for axis in ("surge", "sway", "yaw")
        ),
        next=ManoeuvreState(
            "Drive backwards at 60 %, then turn to port.",
            12.0,
            "X_uu",
            0.21,
            0.12,
            tuple(ahead),
            tuple((0.4 - 0.1 * s, -0.8 + 0.1 * s, 0.6 + 0.05 * s) for s in ahead),
            tuple((-0.6, 0.0) if s < 6.0 else (-0.6, 0.4) for s in ahead),
            0.35,
        ),
        others=(ManoeuvreState("Turn on the spot.", 10.0, "N_r", 0.1, 0.08),),
        uses=(
            UseState("odometry", "fit", "All widths are as needed.", 1.0),
            UseState("control", "limited", "X_uu is 2 times too wide.", 0.7),
            UseState("simulation", "not fit", "Y_v is 5 times too wide.", 0.3),
        ),
        marks=((12.0, "touched the wall"),),
    )


class FakeSession:
    """A `Controller`."""

    def __init__(self, state: LiveState) -> None:
        self.now = state
        self.rows = [(0.2 * i, 0.01 * i, 1.5 * np.sin(0.05 * i), 0.02 * i) for i in range(120)]
        self.calls: list[tuple[str, object]] = []
        self.saving = 0.0  # [s]
        self.asked = 0

    def set(self, **changed: object) -> None:
        self.now = replace(self.now, **changed)

    def state(self) -> LiveState:
        self.asked += 1
        return self.now

    def track(self, since: int) -> tuple[int, list[tuple[float, float, float, float]]]:
        return len(self.rows), self.rows[since:]

    def mark(self, text: str) -> None:
        self.calls.append(("mark", text))
        self.set(marks=(*self.now.marks, (self.now.time, text)))

    def discard(self, seconds: float) -> None:
        if seconds > self.now.time:
            raise LiveError(f"only {self.now.time:g} s are recorded")
        self.calls.append(("discard", seconds))
        self.rows = self.rows[: -round(5 * seconds)]
        self.set(discards=self.now.discards + 1)

    def stop(self) -> dict[str, str]:
        self.calls.append(("stop", None))
        self.set(saving="identifying (40 %)")
        time.sleep(self.saving)
        saved = {"recording": "pool-1/recording", "model": "pool-1/model.yaml"}
        self.set(stopped=True, saving="", saved=tuple(saved.items()))
        return saved
