# SPDX-License-Identifier: MIT
"""The plan of simulated trials: plant, sensor, operator and trials in one file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec

from seatrial.boat.schema import ChainGroup, NotNegative, Positive, Strict
from seatrial.util.errors import FileError
from seatrial.util.files import convert, expect_format, read_yaml

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

    from seatrial.boat.vehicle import Vehicle

PLAN_FORMAT = "plan 1"
MOST_SEEDS = 10_000
LONGEST_SHOWN = 40  # [characters] of a name in an error message
TRIAL = re.compile(r"\w[\w. -]{0,63}")  # a name of files
Range = tuple[float, float]


class DisturbanceForce(Strict, frozen=True):
    """A disturbance force: a first-order Gauss-Markov process in every axis."""

    share: NotNegative  # of full thrust, standard deviation
    correlation: Positive  # [s] its time constant
    earth_fixed: bool = False  # earth-fixed, as wind; else body-fixed


class PlantEntry(Strict, frozen=True):
    """The truth."""

    coefficients: dict[str, float]
    step: Positive  # [s] of the integration
    chain: list[ChainGroup] = msgspec.field(default_factory=list)
    unmodelled: DisturbanceForce | None = None


class Pool(Strict, frozen=True):
    """A rectangular pool around the origin, its length along x."""

    length: Positive  # [m]
    width: Positive  # [m]
    margin: NotNegative  # [m] that the operator keeps from the walls


class DropOuts(Strict, frozen=True):
    """Intervals without poses."""

    per_minute: NotNegative
    shortest: NotNegative = 0.3  # [s]
    longest: NotNegative = 2.0  # [s]


class Jumps(Strict, frozen=True):
    """False matches."""

    per_minute: NotNegative
    shortest: NotNegative = 0.1  # [m]
    longest: NotNegative = 0.5  # [m]
    samples: Annotated[int, msgspec.Meta(ge=1)] = 3  # poses in a row at most


class PoseSensor(Strict, frozen=True):
    """SLAM as a sensor."""

    rate: Positive  # [Hz]
    position_noise: NotNegative  # [m] standard deviation
    heading_noise: NotNegative  # [rad]
    stamp_jitter: NotNegative  # [s]
    drop_outs: DropOuts
    jumps: Jumps
    noise_correlation: NotNegative = 0.0  # [s] time constant of the noise; 0: white
    position_delay: NotNegative = 0.0  # [s] by which positions are older than their stamps
    heading_delay: NotNegative = 0.0  # [s] by which headings are


class Joypad(Strict, frozen=True):
    """Rate and clock of the commands."""

    rate: Positive  # [Hz]
    clock_offset: float  # [s]


class OperatorEntry(Strict, frozen=True):
    """Reaction, amplitudes and pulses of the operator, and what it expects of the boat."""

    reaction: Positive  # [s]
    amplitude: dict[Literal["surge", "sway", "yaw"], Range]
    pulse: Range  # [s]
    pause: Range  # [s]
    crosstalk: NotNegative = 0.0  # standard deviation of the other sticks, as a share of a pulse
    throttle: NotNegative = 0.0  # surge stick in a yaw pulse: a rudder turns a boat that moves
    lap: tuple[Positive, Positive] = (18.0, 30.0)  # [s] of a course
    braking: Positive = 0.12  # [m/s^2] deceleration by full reverse
    look_ahead: Positive = 0.5  # [s] of motion before the boat brakes or turns


class TrialEntry(Strict, frozen=True):
    """One trial."""

    drive: Literal["surge", "sway", "yaw", "courses"]
    duration: Positive  # [s]


class PlanFile(Strict, frozen=True):
    """A plan file.

    seatrial: kind and version of the file
    name: of the plan
    seed: of all random numbers
    vehicles: vehicle files, or names of bundled ones
    plant: the true boat
    pool: [m] walls
    pose: the sensor of poses
    joypad: as it samples the commands
    operator: reaction, amplitudes and pulses of who drives
    trials: by name: the axis that is driven, or courses, and for how long
    """

    seatrial: Literal["plan 1"]
    name: str
    seed: Annotated[int, msgspec.Meta(ge=0)]
    vehicles: list[str]
    plant: PlantEntry
    pool: Pool
    pose: PoseSensor
    joypad: Joypad
    operator: OperatorEntry
    trials: dict[str, TrialEntry]


def load_plan(path: str | Path) -> PlanFile:
    """A plan from a file, or a bundled one by its name."""
    plan = convert(_resolved(path), PlanFile, path)
    for name in plan.trials:
        if not TRIAL.fullmatch(name):
            raise FileError(
                f"{path}: trial '{name[:40]}': its files have this name: 1 to 64 letters, digits, _ - . or spaces"
            )
    return plan


def with_seed(plan: PlanFile, seed: int) -> PlanFile:
    """The same plan with other random numbers."""
    if seed < 0:
        raise FileError(f"seed {seed}: expected a whole number from 0 on")
    return msgspec.structs.replace(plan, seed=seed)


def seeded(
    plan: PlanFile, vehicles: Sequence[Vehicle], count: int, out: Path
) -> Iterator[tuple[PlanFile, Vehicle, Path]]:
    """The plan with `count` seeds from its own on, each with its vehicle and folder. Raises FileError."""
    if not 1 <= count <= MOST_SEEDS:
        raise FileError(f"--seeds {count}: expected 1 to {MOST_SEEDS}")
    seeds = range(plan.seed, plan.seed + count)
    width = len(str(seeds[-1]))
    for seed in seeds:
        for place, vehicle in enumerate(vehicles):
            more = f"-{place + 1}" if len(vehicles) > 1 else ""
            yield with_seed(plan, seed), vehicle, out / f"seed-{seed:0{width}}{more}"


def plan_names() -> list[str]:
    """Names of the bundled plans."""
    folder = resources.files("seatrial") / "data" / "plans"
    return sorted(
        p.name.removesuffix(".yaml") for p in folder.iterdir() if p.name.endswith(".yaml")
    )


def _resolved(path: str | Path) -> dict[str, Any]:
    """The content of a file or of a bundled plan, on that of its base."""
    given = Path(path)
    if not given.exists() and str(path) not in plan_names():
        raise FileError(f"{path}: no such plan; give a file or one of {', '.join(plan_names())}")
    return _on_base(read_yaml(given if given.is_file() else _bundled(str(path))), path)


def _on_base(content: dict[str, Any], path: str | Path) -> dict[str, Any]:
    expect_format(content, PLAN_FORMAT, path)
    base = content.pop("based_on", None)
    if base is None:
        return content
    if base not in plan_names():  # a name, never a path
        raise FileError(
            f"{path}: based_on: no bundled plan is named '{str(base)[:LONGEST_SHOWN]}'; "
            f"there are {', '.join(plan_names())}"
        )
    return _merged(_on_base(read_yaml(_bundled(base)), base), content)


def _bundled(name: str) -> Traversable:
    return resources.files("seatrial") / "data" / "plans" / f"{name}.yaml"


def _merged(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    """Deep merge: mappings key by key, all else replaced. `trials` and `vehicles` replace whole."""
    out = dict(base)
    for key, value in over.items():
        deep = isinstance(value, dict) and isinstance(out.get(key), dict) and key != "trials"
        out[key] = _merged(out[key], value) if deep else value
    return out
