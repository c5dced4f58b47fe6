# SPDX-License-Identifier: MIT
"""Settings of simulated sensors; defaults are the core's (`core/.../sensors.hpp`)."""

from __future__ import annotations

from typing import Annotated, TypeVar

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.schema import NotNegative, Positive, Strict
from seatrial.simulation.plan import PoseSensor
from seatrial.util.errors import SimulatorError

S = TypeVar("S", _core.PoseSensor, _core.Imu, _core.Lidar)
Count = Annotated[int, msgspec.Meta(ge=1)]


class PoseSettings(Strict, frozen=True):
    """SLAM as a sensor: noise, delay, drop-outs, false matches."""

    rate: Positive | None = None  # [Hz]
    position_noise: NotNegative | None = None  # [m] standard deviation
    heading_noise: NotNegative | None = None  # [rad]
    noise_correlation: NotNegative | None = None  # [s] time constant of the noise; 0: white
    stamp_jitter: NotNegative | None = None  # [s] standard deviation
    delay: NotNegative | None = None  # [s] from the stamp to the arrival
    drop_outs: NotNegative | None = None  # a minute
    drop_out_shortest: NotNegative | None = None  # [s]
    drop_out_longest: NotNegative | None = None  # [s]
    jumps: NotNegative | None = None  # false matches a minute
    jump_shortest: NotNegative | None = None  # [m]
    jump_longest: NotNegative | None = None  # [m]
    jump_samples: Count | None = None  # poses in a row at most

    @classmethod
    def of_plan(cls, sensor: PoseSensor, delay: float = 0.0) -> PoseSettings:
        """The pose sensor of a plan's recorded trials, with a delay [s]."""
        drop_outs, jumps = sensor.drop_outs, sensor.jumps
        return cls(
            sensor.rate, sensor.position_noise, sensor.heading_noise, sensor.noise_correlation,
            sensor.stamp_jitter, delay, drop_outs.per_minute, drop_outs.shortest, drop_outs.longest,
            jumps.per_minute, jumps.shortest, jumps.longest, jumps.samples,
        )  # fmt: skip


class ImuSettings(Strict, frozen=True):
    """An inertial unit at the origin: yaw rate, and acceleration along the hull's axes."""

    rate: Positive | None = None  # [Hz]
    yaw_rate_noise: NotNegative | None = None  # [rad/s] standard deviation
    yaw_rate_bias: NotNegative | None = None  # [rad/s] standard deviation; drawn once
    acceleration_noise: NotNegative | None = None  # [m/s^2]
    acceleration_bias: NotNegative | None = None  # [m/s^2]


class LidarSettings(Strict, frozen=True):
    """A scanning LiDAR; its first beam is to starboard."""

    rate: Positive | None = None  # [Hz] turns of the mirror
    field: Positive | None = None  # [rad] from the first beam to the last, symmetric to forward
    beams: Count | None = None
    nearest: NotNegative | None = None  # [m]
    farthest: Positive | None = None  # [m]
    noise: NotNegative | None = None  # [m] standard deviation
    bias: float | None = None  # [m]
    mount: tuple[float, float, float] | None = None  # [m, m, rad] forward, left, direction


class Sensors(Strict, frozen=True, omit_defaults=False):
    """Sensors of a boat; None: no such sensor."""

    pose: PoseSettings | None = PoseSettings()
    imu: ImuSettings | None = ImuSettings()
    lidar: LidarSettings | None = LidarSettings()


def core_pose(
    settings: PoseSettings | None,
    lever: tuple[float, float],
    delays: tuple[float, float] = (0.0, 0.0),
) -> _core.PoseSensor | None:
    """The core's pose sensor of a point at `lever` [m]: forward, left of the origin.

    delays: [s] by which position and heading are older than their stamp.
    """
    sensor = filled(_core.PoseSensor(), settings)
    if sensor is not None:
        sensor.set_lever(np.array(lever, dtype=float))
        sensor.position_delay, sensor.heading_delay = delays
    return sensor


def core_lidar(settings: LidarSettings | None) -> _core.Lidar | None:
    """The core's LiDAR."""
    sensor = filled(_core.Lidar(), settings)
    if sensor is not None and settings is not None and settings.mount is not None:
        sensor.set_mount(np.array(settings.mount, dtype=float))
    return sensor


def filled(sensor: S, settings: msgspec.Struct | None) -> S | None:
    """The core's sensor with these settings; None: there is none."""
    if settings is None:
        return None
    for name, value in msgspec.structs.asdict(settings).items():
        if value is not None and name != "mount":
            setattr(sensor, name, value)
    return sensor


def check(pose: _core.PoseSensor | None, imu: _core.Imu | None, lidar: _core.Lidar | None) -> None:
    """Raise SimulatorError where the core refuses a sensor."""
    if fault := _core.sensor_fault(pose, imu, lidar):
        raise SimulatorError(f"sensors: {fault}")
