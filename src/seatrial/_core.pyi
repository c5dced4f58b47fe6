"""
The core of seatrial: model, thrusters, integration, sensitivities (C++).
"""

from collections.abc import Sequence
from typing import Annotated

import numpy
from numpy.typing import NDArray


MAX_FORCES: int = 8

MAX_FACTORS: int = 4

MAX_TERMS: int = 48

MAX_ACTUATORS: int = 8

MAX_COEFFICIENTS: int = 40

MAX_CONSTANTS: int = 32

MAX_SCALES: int = 4

MAX_TABLE: int = 256

FIRST_FORCE: int = 6

class Structure:
    def __init__(self, rows: Sequence[tuple[int, int, float, int, Sequence[int]]], n_coefficients: int, n_forces: int) -> None:
        """
        rows: (axis, coefficient or -1, number, acceleration or -1, [factor codes]) each.
        """

class Chain:
    def __init__(self, scheme: int, inverse: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], offset: float, limit: float, mix: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], actuators: Annotated[NDArray[numpy.int32], dict(shape=(None, None), order='C', device='cpu', writable=False)], n_constants: int, scale_reference: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], table: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], deflection: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None: ...

class Boat:
    def __init__(self, structure: Structure, coefficient: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], integrator: int, longest_step: float) -> None: ...

class ThrustTrace:
    def __init__(self, chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], commands: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], scale_time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], scales: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], initial: bool = False, coefficients: Sequence[int] = [], constants: Sequence[int] = []) -> None: ...

    @property
    def breaks(self) -> int: ...

    def forces(self, time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """Generalised forces F at time [s]: n x forces."""

class Plant:
    def __init__(self, boat: Boat, chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def command(self, t: float, values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> bool: ...

    def advance_to(self, t: float) -> bool: ...

    @property
    def time(self) -> float: ...

    @property
    def state(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    @state.setter
    def state(self, arg: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], /) -> None: ...

    def forces(self, n_forces: int) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

def simulate(boat: Boat, trace: ThrustTrace, x0: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], sensitivities: bool = False) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None, None, None))]]:
    """
    States at time (n x 6) from x0 at time[0], and d state / d columns (n x 6 x columns).
    """

def predict(boat: Boat, trace: ThrustTrace, time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], start: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)], stop: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)], x0: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], threads: int = 1, sensitivities: bool = False) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None, None, None))]]:
    """State at the stop of every start (m x 6), and its sensitivities."""

def lookahead(boat: Boat, trace: ThrustTrace, time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], start: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)], stop: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)], x0: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], earth_fixed: bool = False, threads: int = 1) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
    """
    State at the stop of every start (m x 6), from the filter's (m x 9) with its disturbance.
    """

def levels_after(chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], level: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], target: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], h: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
    """Levels of all actuators h [s] after these, with constant targets."""

class FilterRun:
    @property
    def good(self) -> bool: ...

    @property
    def cost(self) -> float: ...

    @property
    def repeatable(self) -> bool: ...

    def forget_transitions(self) -> None: ...

    def forget_poses(self) -> None: ...

    @property
    def information(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def gradient(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    @property
    def score(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def share(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def innovation(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def spread(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def state(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def deviation(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    @property
    def weight(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

class Series:
    def __init__(self, time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], eta: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], use: Annotated[NDArray[numpy.int8], dict(shape=(None,), order='C', device='cpu', writable=False)], start: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], afresh: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)] | None = None, position_delay: float = 0.0, parts: Annotated[NDArray[numpy.int8], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, asynchronous: tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], Annotated[NDArray[numpy.int8], dict(shape=(None,), order='C', device='cpu', writable=False)], Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], float] | None = None, input_errors: tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]] | None = None) -> None: ...

class GrowingRun:
    """A filter run along a recording that grows."""

    def __init__(self, boat: Boat, trace: ThrustTrace, series: Series, noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], outlier: float, effects: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, earth_fixed: bool = False) -> None: ...

    def advance(self, trace: ThrustTrace, series: Series, until: float) -> bool: ...

    def sums(self) -> FilterRun: ...

    @property
    def good(self) -> bool: ...

    @property
    def time(self) -> float: ...

    @property
    def state(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

EFFECTS: int = 15

POSITION_PART: int = 1

HEADING_PART: int = 2

RATE_PART: int = 4

NO_COLOUR: float = 1e-08

NO_TURN: float = 0.001

USE_JUMPED: int = 2

USE_GAPPED: int = 3

USE_BEGINNING: int = 4

def give_back() -> None: ...

def innovations(boat: Boat, trace: ThrustTrace, series: Series, noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], outlier: float, effects: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, counts: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, blocks: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, repeatable: bool = True, shares: bool = False, earth_fixed: bool = False) -> FilterRun: ...

def noise_slopes(first: FilterRun, series: Series, noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], moved: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], steps: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], outlier: float, step: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, slopes: bool = False) -> tuple[float, Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None, None))]]: ...

def repeated(first: FilterRun, series: Series, noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], outlier: float, step: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, slopes: bool = False) -> float: ...

def relinearised(first: FilterRun, series: Series, noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], outlier: float, step: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, slopes: bool = False, blocks: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None) -> FilterRun: ...

def smoothed(first: FilterRun, series: Series, noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], outlier: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None, None))]]:
    """
    States (n x 9) from the poses before and after each, and standard deviations (n x 3) of the velocity.
    """

def lookahead_variance(first: FilterRun, series: Series, noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], outlier: float, from_pose: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)], to_pose: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)], disturbed: bool = False) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
    """
    Variances (m x 3) of predictions that start from the filter, with or without its disturbance.
    """

def health_words() -> list[tuple[int, str, str]]: ...

class OnboardModel:
    def __init__(self, boat: Boat, chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], considered: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], earth_fixed: bool, current: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], timeout: float | None, speeds: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], forces: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], spread: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], window: float, delays: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

class Predictor:
    def __init__(self, model: OnboardModel) -> None: ...

    def command(self, t: float, values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> int: ...

    def scale(self, t: float, values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> int: ...

    def pose(self, t: float, eta: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], covariance: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)] | None = None, parts: int = 3) -> int: ...

    def at(self, t: float) -> tuple[float, Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None,))], float, int]: ...

    def forget(self) -> None: ...

    def copy(self) -> Predictor: ...

    @property
    def newest(self) -> float: ...

class Odometer:
    def __init__(self, model: OnboardModel, lever: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def command(self, stamp: int, values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> int: ...

    def scale(self, stamp: int, values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> int: ...

    def pose(self, stamp: int, eta: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], covariance: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)] | None = None, parts: int = 3) -> int: ...

    def look(self, stamp: int) -> tuple[float, Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None,))], float, int]: ...

    def at(self, stamp: int) -> tuple[int, bool, Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None,))], tuple[float, Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None,))], float, int]]: ...

    def copy(self) -> Odometer: ...

    @property
    def newest(self) -> int: ...

    def reload(self, model: OnboardModel, lever: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None: ...

    def count(self, source: int, taken: int) -> int: ...

def onboard_uncertainty(boat: Boat, chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], speeds: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], covariance: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], noise: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], explained: bool) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,))], Annotated[NDArray[numpy.float64], dict(shape=(None, None))]]: ...

class Allocator:
    def __init__(self, chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], effectiveness: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], commands: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], scheme: int, inverted: bool, hysteresis: float, rank: Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> None:
        """commands (3, n): limit, idle forward, idle astern."""

    @property
    def fault(self) -> int: ...

    @property
    def idle_power(self) -> float: ...

    @property
    def sides(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    @property
    def edges(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

    def reset(self) -> None: ...

    def allocate(self, wrench: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None,))]]:
        """Commands (m x n), shares (m x 3), whether thrusters were held (m)."""

    def wrench(self, command: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None,))]]:
        """Wrench (m x 3) and power (m)."""

    def command(self, thrust: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """Commands (m x n) that give thrusts (m x n)."""

    def thrust(self, command: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]:
        """Thrusts (m x n) at commands (m x n)."""

    def reach(self, direction: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], most: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

class Steering:
    def __init__(self, boat: Boat, chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], limit: float = 1.0) -> None:
        """One thruster with an angle; limit: of both commands."""

    @property
    def fault(self) -> int: ...

    @property
    def thrust(self) -> int:
        """Its input."""

    @property
    def angle(self) -> int:
        """Its input."""

    @property
    def trim(self) -> float:
        """[rad] angle at no command."""

    @property
    def full_angle(self) -> float:
        """[rad] from the trim at full command."""

    @property
    def angle_rate(self) -> float:
        """[rad/s]; 0: no limit."""

    @property
    def thrusts(self) -> tuple[float, float]: ...

    @property
    def sines(self) -> tuple[float, float]: ...

    def commands(self, thrust: float, angle: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """Commands (2,) whose steady thrust and angle [rad] these are."""

    def authority(self, speed: float) -> tuple[float, float, float]:
        """
        Surge and yaw acceleration by full commands at a speed ahead [m/s], and 1, or -1 where a positive command turns the bow to starboard.
        """

    def effect(self, nu: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """
        along, turn, across, flow, sway_across, sway_flow (6,): accelerations at a motion.
        """

    def command(self, surge: float, yaw: float, nu: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], dt: float) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,))], bool]:
        """
        Commands (2,) for accelerations, dt [s] after the last; whether they give both.
        """

    def forget(self) -> None: ...

class Tracker:
    def __init__(self, boat: Boat, chain: Chain, gains: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], mix: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], limit: float, feed_forward: bool, allocator: Allocator | None, guidance: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], steering: Steering | None = None) -> None:
        """
        allocator: for inputs that are the thrusters; without it the boat's own allocation. guidance: time, radius, slowest, fastest, approach; a time of 0: none. steering: for one thruster with an angle.
        """

    def command(self, inputs: int, dt: float, eta: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], nu: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], now: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], ahead: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None,))], int]:
        """Commands (inputs,), and the status of the call."""

    def forget(self) -> None: ...

    @property
    def drift(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
        """
        Drift velocity that is compensated, earth-fixed [m/s], and the direction [rad].
        """

    @property
    def integral(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

HULL_RADIUS: float = 0.3

STRONGEST_COMMAND: float = 1000.0

class Scene:
    def __init__(self, segments: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], circles: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> None: ...

    def ranges(self, origin: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], angle: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    def distance(self, points: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

def box(x: float, y: float, length: float, width: float, turn: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

class PoseSensor:
    def __init__(self) -> None: ...

    @property
    def rate(self) -> float: ...

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def position_noise(self) -> float: ...

    @position_noise.setter
    def position_noise(self, arg: float, /) -> None: ...

    @property
    def heading_noise(self) -> float: ...

    @heading_noise.setter
    def heading_noise(self, arg: float, /) -> None: ...

    @property
    def noise_correlation(self) -> float: ...

    @noise_correlation.setter
    def noise_correlation(self, arg: float, /) -> None: ...

    @property
    def stamp_jitter(self) -> float: ...

    @stamp_jitter.setter
    def stamp_jitter(self, arg: float, /) -> None: ...

    @property
    def delay(self) -> float: ...

    @delay.setter
    def delay(self, arg: float, /) -> None: ...

    @property
    def drop_outs(self) -> float: ...

    @drop_outs.setter
    def drop_outs(self, arg: float, /) -> None: ...

    @property
    def drop_out_shortest(self) -> float: ...

    @drop_out_shortest.setter
    def drop_out_shortest(self, arg: float, /) -> None: ...

    @property
    def drop_out_longest(self) -> float: ...

    @drop_out_longest.setter
    def drop_out_longest(self, arg: float, /) -> None: ...

    @property
    def jumps(self) -> float: ...

    @jumps.setter
    def jumps(self, arg: float, /) -> None: ...

    @property
    def jump_shortest(self) -> float: ...

    @jump_shortest.setter
    def jump_shortest(self, arg: float, /) -> None: ...

    @property
    def jump_longest(self) -> float: ...

    @jump_longest.setter
    def jump_longest(self, arg: float, /) -> None: ...

    @property
    def jump_samples(self) -> int: ...

    @jump_samples.setter
    def jump_samples(self, arg: int, /) -> None: ...

    @property
    def position_delay(self) -> float: ...

    @position_delay.setter
    def position_delay(self, arg: float, /) -> None: ...

    @property
    def heading_delay(self) -> float: ...

    @heading_delay.setter
    def heading_delay(self, arg: float, /) -> None: ...

    def set_lever(self, arg: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], /) -> None: ...

class Imu:
    def __init__(self) -> None: ...

    @property
    def rate(self) -> float: ...

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def yaw_rate_noise(self) -> float: ...

    @yaw_rate_noise.setter
    def yaw_rate_noise(self, arg: float, /) -> None: ...

    @property
    def yaw_rate_bias(self) -> float: ...

    @yaw_rate_bias.setter
    def yaw_rate_bias(self, arg: float, /) -> None: ...

    @property
    def acceleration_noise(self) -> float: ...

    @acceleration_noise.setter
    def acceleration_noise(self, arg: float, /) -> None: ...

    @property
    def acceleration_bias(self) -> float: ...

    @acceleration_bias.setter
    def acceleration_bias(self, arg: float, /) -> None: ...

class Lidar:
    def __init__(self) -> None: ...

    @property
    def rate(self) -> float: ...

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def field(self) -> float: ...

    @field.setter
    def field(self, arg: float, /) -> None: ...

    @property
    def beams(self) -> int: ...

    @beams.setter
    def beams(self, arg: int, /) -> None: ...

    @property
    def nearest(self) -> float: ...

    @nearest.setter
    def nearest(self, arg: float, /) -> None: ...

    @property
    def farthest(self) -> float: ...

    @farthest.setter
    def farthest(self, arg: float, /) -> None: ...

    @property
    def noise(self) -> float: ...

    @noise.setter
    def noise(self, arg: float, /) -> None: ...

    @property
    def bias(self) -> float: ...

    @bias.setter
    def bias(self, arg: float, /) -> None: ...

    def set_mount(self, arg: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], /) -> None: ...

    def angles(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    def sweep(self) -> float: ...

def sensor_fault(pose: PoseSensor | None, imu: Imu | None, lidar: Lidar | None) -> str:
    """Why they are refused; '': they are not."""

class Simulator:
    def __init__(self, scene: Scene, current: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], seed: int) -> None: ...

    def add(self, boat: Boat, chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], start: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], radius: float, pose: PoseSensor | None = None, imu: Imu | None = None, lidar: Lidar | None = None) -> int:
        """
        Number of the boat; -1 where there is no room for its hull, or time has begun.
        """

    def command(self, boat: int, values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> bool: ...

    def advance_to(self, t: float) -> bool: ...

    def take(self) -> list[tuple[int, int, float, float, Annotated[NDArray[numpy.float64], dict(shape=(None,))]]]:
        """(kind, boat, stamp, arrival, values) of all that have arrived."""

    @property
    def time(self) -> float: ...

    def touched(self, arg: int, /) -> bool: ...

    def state(self, arg: int, /) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

    def forces(self, arg0: int, arg1: int, /) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

class Carrier:
    def __init__(self) -> None: ...

    @property
    def speed(self) -> float: ...

    @speed.setter
    def speed(self, arg: float, /) -> None: ...

    @property
    def yaw_rate(self) -> float: ...

    @yaw_rate.setter
    def yaw_rate(self, arg: float, /) -> None: ...

    @property
    def acceleration(self) -> float: ...

    @acceleration.setter
    def acceleration(self, arg: float, /) -> None: ...

    @property
    def yaw_acceleration(self) -> float: ...

    @yaw_acceleration.setter
    def yaw_acceleration(self, arg: float, /) -> None: ...

    @property
    def lag(self) -> float: ...

    @lag.setter
    def lag(self, arg: float, /) -> None: ...

    @property
    def gain(self) -> float: ...

    @gain.setter
    def gain(self, arg: float, /) -> None: ...

    @property
    def pose_timeout(self) -> float: ...

    @pose_timeout.setter
    def pose_timeout(self, arg: float, /) -> None: ...

    @property
    def lost(self) -> float: ...

    @lost.setter
    def lost(self, arg: float, /) -> None: ...

    def fault(self) -> tuple[str, float, str, str]:
        """Name (empty: none), value, what was expected, what to do."""

class Mimic:
    def __init__(self, boat: Boat, chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], carrier: Carrier, timeout: float) -> None: ...

    def command(self, t: float, values: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> bool: ...

    def pose(self, t: float, eta: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> bool: ...

    def at(self, t: float) -> tuple[float, list[float], list[float], list[float], list[float], int]:
        """
        time, velocity for the carrier, the same before its limits, the virtual boat's state, mismatch, health.
        """

    @property
    def newest(self) -> float:
        """Newest stamp [s] of all inputs and answers."""

def mimic_words() -> list[tuple[int, str]]:
    """Flag and advice of each health flag of a mimic."""

def regressors(structure: Structure, nu: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], nu_dot: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], force: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

def accelerations(structure: Structure, coefficient: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], nu: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], force: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...

def allocate(chain: Chain, wrench: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None))], Annotated[NDArray[numpy.float64], dict(shape=(None,))]]:
    """
    Thruster commands (n x actuators) and the share alpha of each wrench that is given.
    """

def curve(chain: Chain, q: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], actuator: int, command: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]: ...

def wrap(angle: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> Annotated[NDArray[numpy.float64], dict(shape=(None,))]:
    """Angles in (-pi, pi]."""

def rotate(psi: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], rate: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], to_body: bool) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None))]: ...
