# SPDX-License-Identifier: MIT
"""A driver's drive with the live estimate, its verdict, and what it costs."""

import time
from dataclasses import asdict, dataclass, replace

import numpy as np

from benchmarks.harness.store import Record
from benchmarks.studies.poolside.drivers import REACTION, AtRandom, Driver, Guided, Protocol
from benchmarks.studies.poolside.waters import PaperPool, TwinInWind, Water
from seatrial.boat.model import Model
from seatrial.poolside.enough import Enough
from seatrial.poolside.live_estimator import LiveEstimator
from seatrial.poolside.live_prediction import LivePrediction
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95
from seatrial.workflow.fitness import Use

WATERS = {"pool": PaperPool, "twin": TwinInWind}
DRIVERS = {"S1 to S3": Protocol, "at random": AtRandom, "guided": Guided}
WORK, WORK_SHARE = 1.0, 0.02  # [s], of the drive, between two looks at the estimate
LONGEST = 400.0  # [s] of a drive
NANO = 1e9
AT_WALL = 0.05  # [m] into the boat's radius, from which on it is at a wall


@dataclass(frozen=True)
class Outcome:
    """One drive."""

    enough: float  # [s] until the verdict; infinite: never
    same: float  # [s] until every interval is as narrow as those of S1 to S3 at their end
    inside: tuple[bool, ...]  # whether the 95 % intervals at the verdict hold the truth
    touched: float  # share of the time in which the boat was at a wall
    advice: tuple[float, ...]  # CPU seconds of each piece of advice
    widths: dict[str, float]  # 95 % half-widths at the end


class Drive:
    """One driver's drive, with the live estimate."""

    def __init__(self, water: Water, driver: Driver) -> None:
        self.water, self.driver = water, driver
        self.estimator, self.ahead = LiveEstimator(water.vehicle), LivePrediction()
        self.verdict = Enough(tuple(Use))
        self.model: Model | None = None
        self.at_verdict: Model | None = None
        self.enough = np.inf
        self.advice: list[float] = []

    def run(self, longest: float, goal: dict[str, float], *, verdict: bool = False) -> Outcome:
        """Until the verdict and the goal's half-widths are reached, `longest` [s] at most; `verdict`: it alone."""
        water, ticks, at_wall, same = self.water, round(longest / self.water.tick), 0, np.inf
        latest = -np.inf
        for tick in range(ticks):
            t, x = tick * water.tick, water.state
            at_wall += bool(water.area.margin(*x[:2].tolist()) < water.radius - AT_WALL)
            row = self._commands(t, x)
            self._use("command", t + water.offset, row)
            for stamp, pose in water.step(row):
                self._use("pose", stamp, pose)
            if t < latest + max(WORK, WORK_SHARE * t) or not self.estimator.work():
                continue
            latest = t
            self._new(t)
            if not np.isfinite(same) and goal and reached(self.model, goal):
                same = t
            if np.isfinite(self.enough) and (verdict or np.isfinite(same)):
                break
        assert self.model is not None
        checked = self.at_verdict or self.model
        return Outcome(
            self.enough, same, inside(checked, water), at_wall / (tick + 1), tuple(self.advice),
            widths(self.model),
        )  # fmt: skip

    def _commands(self, t: float, x: Array) -> Array:
        begin = time.process_time()
        row = self.driver.look(t, x)
        if isinstance(self.driver, Guided):
            self.driver.coverage.add(t, x[3:], row)
            if self.driver.begun == t + REACTION and self.model is not None:
                self.advice.append(time.process_time() - begin)
        return row

    def _use(self, kind: str, t: float, values: Array) -> None:
        stamp = round(NANO * (t + 1.0))
        self.estimator.use(kind, stamp, values)
        self.ahead.use(kind, stamp, values)

    def _new(self, t: float) -> None:
        self.model = self.estimator.model()
        assert self.model is not None
        self.ahead.reload(self.model)
        self.verdict.update(t, self.model, self.ahead.states(), whole=self.estimator.whole)
        if self.verdict.enough and not np.isfinite(self.enough):
            self.enough, self.at_verdict = t, self.model
        if isinstance(self.driver, Guided):
            self.driver.model, self.driver.needs = self.model, self.verdict.needs
            self.driver.trust = self.estimator.trust


def widths(model: Model) -> dict[str, float]:
    """95 % half-widths of what was estimated."""
    return {n: NORMAL_95 * e for n, e in model.standard_errors.items() if e > 0.0}


def reached(model: Model | None, goal: dict[str, float]) -> bool:
    """Whether the median interval is as narrow as the goal's, of the parameters of both."""
    own = {} if model is None else widths(model)
    ratios = [own[n] / goal[n] for n in goal if n in own]
    return len(ratios) > 0 and float(np.median(ratios)) <= 1.0


def inside(model: Model, water: Water) -> tuple[bool, ...]:
    """Of every estimated parameter whether its 95 % interval holds the truth."""
    own = widths(model)
    values = {
        **model.values,
        **dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True)),
    }
    truth = dict(zip(own, water.truth(tuple(own)).tolist(), strict=True))
    return tuple(bool(abs(values[n] - truth[n]) <= own[n]) for n in own)


def record(goals: dict[str, dict[str, float]], water: str, seed: int, name: str) -> Record:
    """One drive, as values of JSON; goals: half-widths that S1 to S3 reach, by water and seed."""
    own = WATERS[water](seed)
    driver = DRIVERS[name](own, seed)
    goal = goals.get(f"{water} {seed}", {})
    longest = driver.length if isinstance(driver, Protocol) else LONGEST
    found = Drive(own, driver).run(longest, goal)
    return asdict(found if goal else replace(found, same=longest))
