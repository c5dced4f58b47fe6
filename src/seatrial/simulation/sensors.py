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
    """SLAM as a sensor: noise, delay, drop-outs, false matches.

    rate: [Hz]
    position_noise: [m] standard deviation
    heading_noise: [rad]
    noise_correlation: [s] time constant of the noise; 0: white
    stamp_jitter: [s] standard deviation
    delay: [s] from the stamp to the arrival
    drop_outs: a minute
    drop_out_shortest: [s]
    drop_out_longest: [s]
    jumps: false matches a minute
    jump_shortest: [m]
    jump_longest: [m]
    jump_samples: poses in a row at most
    """

    rate: Positive | None = None
    position_noise: NotNegative | None = None
    heading_noise: NotNegative | None = None
    noise_correlation: NotNegative | None = None
    stamp_jitter: NotNegative | None = None
    delay: NotNegative | None = None
    drop_outs: NotNegative | None = None
    drop_out_shortest: NotNegative | None = None
    drop_out_longest: NotNegative | None = None
    jumps: NotNegative | None = None
    jump_shortest: NotNegative | None = None
    jump_longest: NotNegative | None = None
    jump_samples: Count | None = None

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
    """An inertial unit at the origin: yaw rate, and acceleration along the hull's axes.

    rate: [Hz]
    yaw_rate_noise: [rad/s] standard deviation
    yaw_rate_bias: [rad/s] standard deviation; drawn once
    acceleration_noise: [m/s^2]
    acceleration_bias: [m/s^2]
    """

    rate: Positive | None = None
    yaw_rate_noise: NotNegative | None = None
    yaw_rate_bias: NotNegative | None = None
    acceleration_noise: NotNegative | None = None
    acceleration_bias: NotNegative | None = None


class LidarSettings(Strict, frozen=True):
    """A scanning LiDAR; its first beam is to starboard.

    rate: [Hz] turns of the mirror
    field: [rad] from the first beam to the last, symmetric to forward
    beams: rays in a turn
    nearest: [m]
    farthest: [m]
    noise: [m] standard deviation
    bias: [m]
    mount: [m, m, rad] forward, left, direction
    """

    rate: Positive | None = None
    field: Positive | None = None
    beams: Count | None = None
    nearest: NotNegative | None = None
    farthest: Positive | None = None
    noise: NotNegative | None = None
    bias: float | None = None
    mount: tuple[float, float, float] | None = None


class Sensors(Strict, frozen=True, omit_defaults=False):
    """Sensors of a boat; None: no such sensor.

    pose: SLAM, motion capture or GNSS
    imu: inertial unit
    lidar: scanning LiDAR
    """

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
