# SPDX-License-Identifier: MIT
"""Messages of ArduPilot, PX4, MAVLink and MOOS that hold positions, headings, yaw rates, motor outputs, voltages.

The autopilots' axes are north, east, down and forward, right, down: headings are clockwise from north, yaw
rates clockwise.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from seatrial.io.log import Log, LogTopic


@dataclass(frozen=True)
class Known:
    """A signal that a message holds."""

    message: str
    fields: tuple[str, ...]
    what: str
    # unit, scale: as a vehicle file has them
    column: Mapping[str, Any] = field(default_factory=dict)
    geographic: bool = False  # latitude and longitude; else metres north and east
    fix: str = ""  # field of a receiver's kind of fix: 3 without corrections, 4 with, 5 and 6 RTK

    def is_in(self, topic: LogTopic) -> bool:
        """Whether a topic holds it."""
        return topic.type == self.message and set(self.fields) <= set(topic.fields)

    def topics(self, log: Log) -> list[LogTopic]:
        """Topics of the log's own autopilot that hold it."""
        return [t for t in log.topics.values() if "@" not in t.name and self.is_in(t)]

    def fields_in(self, topic: LogTopic) -> tuple[str, ...]:
        """Its fields, and the kind of fix behind them where the topic has it."""
        return (*self.fields, *([self.fix] if self.fix in topic.fields else []))


E7 = {"scale": 1e7}
FIX = "fix_type"
POSITIONS = (  # the most raw first: the errors of a filter's output are correlated over a long time
    Known("GPS", ("Lat", "Lng"), "GNSS receiver", geographic=True, fix="Status"),
    Known("GPS2", ("Lat", "Lng"), "GNSS receiver", geographic=True, fix="Status"),
    Known("vehicle_gps_position", ("latitude_deg", "longitude_deg"), "GNSS receiver", geographic=True, fix=FIX),
    Known("vehicle_gps_position", ("lat", "lon"), "GNSS receiver", E7, geographic=True, fix=FIX),
    Known("sensor_gps", ("latitude_deg", "longitude_deg"), "GNSS receiver", geographic=True, fix=FIX),
    Known("sensor_gps", ("lat", "lon"), "GNSS receiver", E7, geographic=True, fix=FIX),
    Known("GPS_RAW_INT", ("lat", "lon"), "GNSS receiver", E7, geographic=True, fix=FIX),
    Known("GPS2_RAW", ("lat", "lon"), "GNSS receiver", E7, geographic=True, fix=FIX),
    Known("GPS_XY", ("GPS_Y", "GPS_X"), "GNSS receiver"),
    Known("VISP", ("PX", "PY"), "external position"),
    Known("vehicle_visual_odometry", ("position[0]", "position[1]"), "external position"),
    Known("vehicle_mocap_odometry", ("position[0]", "position[1]"), "external position"),
    Known("POS", ("Lat", "Lng"), "autopilot's filter", geographic=True),
    Known("vehicle_global_position", ("lat", "lon"), "autopilot's filter", geographic=True),
    Known("GLOBAL_POSITION_INT", ("lat", "lon"), "autopilot's filter", E7, geographic=True),
    Known("vehicle_local_position", ("x", "y"), "autopilot's filter"),
    Known("vehicle_odometry", ("position[0]", "position[1]"), "autopilot's filter"),
    Known("LOCAL_POSITION_NED", ("x", "y"), "autopilot's filter"),
    Known("NAV_XY", ("NAV_Y", "NAV_X"), "navigation of MOOS"),
    Known("NAV_LATLONG", ("NAV_LAT", "NAV_LONG"), "navigation of MOOS", geographic=True),
    Known("XKF1", ("PN", "PE"), "autopilot's filter"),
    Known("NKF1", ("PN", "PE"), "autopilot's filter"),
)  # fmt: skip
QUATERNION = ("q[1]", "q[2]", "q[3]", "q[0]")  # x, y, z, w
HEADINGS = (
    Known("ATT", ("Yaw",), "attitude filter", {"unit": "deg"}),
    Known("vehicle_attitude", QUATERNION, "attitude filter"),
    Known("ATTITUDE", ("yaw",), "attitude filter"),
    Known("XKF1", ("Yaw",), "attitude filter", {"unit": "deg"}),
    Known("NKF1", ("Yaw",), "attitude filter", {"unit": "deg"}),
    Known("vehicle_local_position", ("heading",), "attitude filter"),
    Known("vehicle_odometry", QUATERNION, "attitude filter"),
    Known("GLOBAL_POSITION_INT", ("hdg",), "attitude filter", {"unit": "deg", "scale": 100.0}),
    Known("VFR_HUD", ("heading",), "attitude filter, whole degrees", {"unit": "deg"}),
    Known("NAV_HEADING", ("NAV_HEADING",), "navigation of MOOS", {"unit": "deg"}),
    Known("COMPASS_HEADING", ("COMPASS_HEADING",), "compass", {"unit": "deg"}),
    Known("GPS", ("Yaw",), "two antennas", {"unit": "deg"}),
    Known("sensor_gps", ("heading",), "two antennas"),
)
YAW_RATES = (
    Known("IMU", ("GyrZ",), "gyro"),
    Known("vehicle_angular_velocity", ("xyz[2]",), "gyro"),
    Known("sensor_combined", ("gyro_rad[2]",), "gyro"),
    Known("ATTITUDE", ("yawspeed",), "gyro"),
    Known("SCALED_IMU", ("zgyro",), "gyro", {"scale": 1e3}),
)
VOLTAGES = (
    Known("BAT", ("Volt",), "battery voltage"),
    Known("CURR", ("Volt",), "battery voltage"),
    Known("battery_status", ("voltage_v",), "battery voltage"),
    Known("SYS_STATUS", ("voltage_battery",), "battery voltage", {"scale": 1e3}),
)
OUTPUTS = (  # messages whose fields are motor outputs, those with the most direct units first
    "actuator_motors",
    "actuator_servos",
    "RCOU",
    "RCO2",
    "SERVO_OUTPUT_RAW",
    "actuator_outputs",
    "PYDIR_THRUST_L",
    "DESIRED_THRUST_L",
    "DESIRED_THRUST",
    "PYDIR_THRUST_R",
    "DESIRED_THRUST_R",
    "DESIRED_RUDDER",
)
BESIDE = {  # outputs of the same boat beside those of a message
    "actuator_motors": "actuator_servos",
    "PYDIR_THRUST_L": "PYDIR_THRUST_R",
    "DESIRED_THRUST_L": "DESIRED_THRUST_R",
    "DESIRED_THRUST": "DESIRED_RUDDER",
}


def role(topic: LogTopic) -> str:
    """What a topic may be to a boat: position, heading, yaw rate, commands, battery; or empty."""
    several = {
        "position": POSITIONS, "heading": HEADINGS, "yaw rate": YAW_RATES, "battery": VOLTAGES,
    }  # fmt: skip
    found = [name for name, known in several.items() if any(k.is_in(topic) for k in known)]
    return ", ".join([*found, *(["commands"] if topic.type in OUTPUTS else [])])
