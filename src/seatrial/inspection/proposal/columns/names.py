# SPDX-License-Identifier: MIT
"""What columns of a table are by their names: words of many logs, as data."""

import re
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache


class Kind(str, Enum):
    """What a column may be."""

    STAMP = "stamp"
    NANOSECONDS = "nanoseconds"  # the rest of a stamp in whole seconds
    X = "x"
    Y = "y"
    EAST = "east"
    NORTH = "north"
    LATITUDE = "latitude"
    LONGITUDE = "longitude"
    HEADING = "heading"
    COURSE = "course"  # direction of the motion, not of the boat
    QUATERNION = "quaternion"
    YAW_RATE = "yaw rate"
    VALID = "valid"
    COMMAND = "command"
    MEASURED = "measured"  # another signal, no command


class Grade(int, Enum):
    """How well a name fits."""

    PART = 1  # its last words; of a coordinate, its first
    PREFIXED = 2  # the words, after such as say nothing of the kind: pose, gps, boat
    WHOLE = 3  # the words and nothing else


# words in any case, with any separator between them: `pos x` is pos_x, Pos.X, posX, pos-x (m)
SYNONYMS = {
    Kind.STAMP: (
        "t|time|times|stamp|timestamp|time stamp|ts|clock|elapsed|elapsed time|epoch|unix|unix time|"
        "utc|utc time|utc datetime|date time|datetime|date|sec|secs|second|seconds|s|ms|us|ns|msec|usec|nsec|"
        "millis|micros|nanos|milliseconds|microseconds|nanoseconds|time boot|time since boot|"
        "time utc|time unix|gps time|system time|sys time|local time|rosbag timestamp|stamp sec|time usec|"
        "t capture|host stamp|log time|record time|receive time|publish time|zeit|tow|itow|gps tow|time of week|"
        "tiempo|temps|tempo|tijd|时间|时间戳"
    ),
    Kind.X: "x|px|x pos|pos x|position x|x position|x coordinate|x world|x map|x local|x loc|x est|x meas|eta 1",
    Kind.Y: "y|py|y pos|pos y|position y|y position|y coordinate|y world|y map|y local|y loc|y est|y meas|eta 2",
    Kind.EAST: (
        "e|east|easting|x east|east x|utm x|x utm|utm e|utm east|utm easting|pos e|pe|x enu|enu x|"
        "y ned|ned y|ned e|ned east|enu e|pos east|position east|rechtswert|ost|este"
    ),
    Kind.NORTH: (
        "n|north|northing|y north|north y|utm y|y utm|utm n|utm north|utm northing|pos n|pn|y enu|enu y|"
        "x ned|ned x|ned n|ned north|enu n|pos north|position north|hochwert|nord|norte"
    ),
    Kind.LATITUDE: "lat|latitude|latitud|breite|纬度",
    Kind.LONGITUDE: "lon|lng|long|longitude|longitud|laenge|经度",
    Kind.HEADING: (
        "psi|yaw|heading|hdg|hdt|head|compass|theta|azimuth|true heading|heading true|magnetic heading|"
        "mag heading|heading magnetic|compass heading|gyro heading|yaw angle|heading angle|euler z|rpy z|"
        "euler yaw|rpy yaw|yaw ned|yaw enu|psi ned|heading ned|kurs|rumbo|cap|koers|eta 6|eta 3|"
        "航向|航向角|艏向|艏向角|偏航角"
    ),
    Kind.COURSE: (
        "cog|course|crs|course over ground|track|track angle|track made good|ground course|"
        "course angle|chi"
    ),
    Kind.YAW_RATE: (
        "r|yaw rate|yawrate|yaw speed|yawspeed|psi dot|psidot|heading rate|rate of turn|rot|turn rate|"
        "gyro z|gyr z|gz|gyroscope z|angular velocity z|angular rate z|angular z|ang vel z|rate z|omega z|"
        "wz|w z|omega|yaw velocity"
    ),
    Kind.VALID: "valid|is valid|pose valid|ok|pose ok|good|fix ok|usable",
    Kind.COMMAND: (
        "cmd|command|commands|pwm|servo|motor|thruster|thrust|throttle|rudder|esc|prop|propeller|rpm cmd|"
        "steer|steering|stick|joy|axis|axes|joystick|tau|force|torque|wrench|ch|chan|channel|rc|rcout|rcin|"
        "output|actuator|input|port|starboard|stbd|left|right|bow|stern|surge|sway|f u|f v|f r|fu|fv|fr|"
        "azimuth cmd|delta|n cmd|duty|power|moteur|propulseur|propulsor|gouvernail|timon|roer|ruder|"
        "推进器|左推进器|右推进器|电机|左电机|右电机|油门|左油门|右油门|舵|舵角"
    ),
    Kind.MEASURED: (
        "z|pos z|position z|down|ned d|alt|altitude|height|depth|elevation|roll|pitch|phi|"
        "u|v|w|p|q|vx|vy|vz|vel|velocity|speed|sog|stw|acc|accel|acceleration|ax|ay|az|mag|magnetic|"
        "magnetometer|gyro|gyr|imu|angular|linear|twist|odometer|volt|voltage|battery|batt|current|amps|"
        "temp|temperature|pressure|humidity|wind|wave|gust|sats|satellites|num sats|hdop|vdop|pdop|fix|"
        "fix type|status|mode|state|armed|seq|sequence|id|index|row|count|counter|frame|covariance|cov|"
        "std|sigma|var|variance|error|err|accuracy|age|quality|rssi|snr|distance|zone|hemisphere|rpm|date|year|"
        "month|day|hour|minute|latency|delay"
    ),
}  # fmt: skip
# words beside the kind's own that change nothing
NEUTRAL_WORDS = """
    field data msg msgs message pose position pos loc location local global world map odom odometry nav navigation
    state states est estimate estimated estimator ekf filter filtered kf gps gnss rtk ins imu ahrs mocap vicon
    qualisys optitrack slam boat vessel ship usv asv vehicle robot body base link frame meas measured measurement
    sensor translation transform point eta coordinate coordinates coord value values log header rosbag true
    attitude euler rpy orientation signal signals hat
"""
# words that make another signal of it: a target, an error, a rate
FOREIGN_WORDS = """
    target desired des ref reference setpoint sp goal cmd command waypoint wp home std sigma var cov covariance err
    error accuracy acc accel acceleration mag magnetic vel velo velocity speed twist linear angular gyro gyr rate
    force torque wrench tau wind wave current joy stick axes volt voltage battery batt temp temperature min max
    mean offset bias dot drift delta thrust thruster motor servo pwm rpm roll pitch valid
"""
NEUTRAL, FOREIGN = frozenset(NEUTRAL_WORDS.split()), frozenset(FOREIGN_WORDS.split())
COORDINATES = (Kind.X, Kind.Y, Kind.EAST, Kind.NORTH, Kind.LATITUDE, Kind.LONGITUDE)
NUMBERED = frozenset((Kind.X, Kind.Y, Kind.LATITUDE, Kind.LONGITUDE, Kind.HEADING, Kind.COMMAND))
# words of a command that is an angle
STEERING = frozenset([
    "rudder", "ruder", "steer", "steering", "helm", "tiller", "azimuth", "angle", "deflection", "nozzle",
    "gouvernail", "timon", "roer", "舵", "舵角",
])  # fmt: skip
SPEEDS = frozenset(["rpm", "rps", "nps"])  # units of a propeller's speed
NUMBERED_COMMANDS = ("u", "n", "f", "m", "d", "out")  # with a number: u1, n_2
UNITS = {  # as they end a name, or stand in brackets
    "m": "m", "meter": "m", "meters": "m", "metre": "m", "metres": "m", "cm": "cm", "mm": "mm",
    "ft": "ft", "foot": "ft", "feet": "ft",
    "rad": "rad", "radian": "rad", "radians": "rad", "deg": "deg", "degree": "deg", "degrees": "deg",
    "°": "deg", "grad": "deg", "s": "s", "sec": "s", "secs": "s", "seconds": "s", "ms": "ms", "msec": "ms",
    "millis": "ms", "us": "us", "usec": "us", "micros": "us", "µs": "us", "μs": "us", "ns": "ns", "nsec": "ns",
    "nsecs": "ns", "nanosec": "ns", "nanosecs": "ns", "nanos": "ns", "nanoseconds": "ns",
    "milliseconds": "ms", "microseconds": "us", "rads": "rad", "degs": "deg", "dps": "deg",
}  # fmt: skip
NANOSECOND_WORDS = ("nsec", "nsecs", "nanosec", "nanosecs", "nanos", "nanoseconds", "ns")
PARTS = ("x", "y", "z", "w")  # in brackets
PER_SECOND = re.compile(
    r"\s*(?:/\s*s(?:ec)?|\s+s\^?-?1|[_ ]per[_ ]s|[_ ]?per[_ ]?sec)$", re.IGNORECASE
)
BRACKET = re.compile(r"[\[({]\s*([^\[\](){}]*?)\s*[\])}]\s*$")
CAMEL = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|[^\W\d_A-Za-z]+|\d+")


@dataclass(frozen=True)
class Named:
    """A column's name, read."""

    words: tuple[str, ...]  # lower case, without the unit
    unit: str  # m, deg, ms; empty: not stated
    rate: bool  # the unit is per second


@lru_cache(maxsize=4096)
def read_name(name: str) -> Named:
    """Words and unit of a name."""
    text, unit, rate = name.strip(), "", False
    bracket = BRACKET.search(text)
    if bracket:
        inside = bracket[1].strip()
        bare = PER_SECOND.sub("", inside)
        unit = UNITS.get(bare.lower(), "")
        rate = bare != inside or inside.lower() in ("dps", "rps")
        if inside not in PARTS and not inside.isdecimal():  # quat[x], axes[1]
            text = text[: bracket.start()]
    bare = PER_SECOND.sub("", text)
    rate, text = rate or bare != text, bare
    words = tuple(word.lower() for word in CAMEL.findall(text))
    if not unit and len(words) > 2 and words[-1] == "s" and words[-2] in ("rad", "deg", "m"):
        words, rate = words[:-1], True  # yaw_rate_deg_s
    if not unit and len(words) > 1 and words[-1] in UNITS:
        rate = rate or words[-1] in ("dps", "rads", "degs")
        unit, words = UNITS[words[-1]], words[:-1]
    return Named(words, unit, rate)


def grade(name: str, kind: Kind) -> Grade | None:
    """How well a name fits a kind; None: not at all."""
    if kind is Kind.NANOSECONDS:
        return _nanoseconds(name)
    words = read_name(name).words
    patterns = _patterns(kind)
    if words in patterns:
        return Grade.WHOLE
    numbered = kind in NUMBERED  # yaw_2, pwm1; but n_1 is no north
    bare = tuple(w for w in words if w not in NEUTRAL and not (numbered and w.isdecimal()))
    if bare in patterns or (words and not bare and words[-1:] in patterns):
        return Grade.PREFIXED
    if kind in (Kind.COMMAND, Kind.MEASURED):
        return _by_a_word(words, bare, kind)
    parts = _ends_with(bare, kind) or (kind in COORDINATES and _begins_with(bare, kind))
    return Grade.PART if parts else None


def _by_a_word(words: tuple[str, ...], bare: tuple[str, ...], kind: Kind) -> Grade | None:
    """A command or another signal by any of its words."""
    counted = len(words) == 2 and words[0] in NUMBERED_COMMANDS and words[1].isdecimal()
    if counted:
        return Grade.PREFIXED if kind is Kind.COMMAND else None
    return Grade.PART if any((word,) in _patterns(kind) for word in bare) else None


def _ends_with(words: tuple[str, ...], kind: Kind) -> bool:
    """Whether the last words are of this kind, and none before makes another signal of it."""
    lengths = [len(p) for p in _patterns(kind) if words[-len(p) :] == p]
    return bool(lengths) and not FOREIGN.intersection(words[: -max(lengths)])


def _begins_with(words: tuple[str, ...], kind: Kind) -> bool:
    """Whether the first word is of this kind, x_position_mid, and none after makes another signal of it.

    Initials of north and east are no words: n_left.
    """
    first = words[:1]
    whole = kind in (Kind.X, Kind.Y) or len("".join(first)) > 1
    return whole and first in _patterns(kind) and not FOREIGN.intersection(words[1:])


def _nanoseconds(name: str) -> Grade | None:
    words = tuple(word.lower() for word in CAMEL.findall(name))
    if not words or words[-1] not in NANOSECOND_WORDS:
        return None
    return Grade.WHOLE if len(words) == 1 else Grade.PREFIXED


@lru_cache(maxsize=32)
def _patterns(kind: Kind) -> frozenset[tuple[str, ...]]:
    return frozenset(tuple(words.split()) for words in SYNONYMS[kind].split("|"))


def is_quaternion_part(name: str) -> tuple[tuple[str, ...], str] | None:
    """Of a quaternion's component its other words, and x, y, z or w; q0 to q3 are w, x, y, z."""
    words = read_name(name).words
    if not words:
        return None
    last = words[-1]
    if len(last) == 2 and last[0] == "q" and last[1] in "xyzw":
        return (*words[:-1], "q"), last[1]
    if last in tuple("0123") and len(words) > 1 and words[-2] in ("q", "quat", "quaternion"):
        return words[:-1], "wxyz"[int(last)]
    carriers = ("orientation", "rotation", "quaternion", "quat", "q", "rot", "attitude", "att")
    if last in tuple("xyzw") and any(word in carriers for word in words[:-1]):
        return words[:-1], last
    return None


AXIS_WORDS = frozenset(
    "x y e n east north easting northing lat latitude lon lng long longitude".split()  # noqa: SIM905
)
TIME_WORDS = frozenset(("s", "sec", "secs", "seconds", *NANOSECOND_WORDS))


def family(name: str) -> tuple[str, ...]:
    """The words that a position's two columns, or a stamp's, have in common."""
    words = tuple(word.lower() for word in CAMEL.findall(name))
    return tuple(word for word in words if word not in AXIS_WORDS and word not in TIME_WORDS)


def order(name: str, kind: Kind) -> int:
    """Place among the words of its kind: the usual ones are first."""
    words = " ".join(read_name(name).words)
    listed = SYNONYMS[kind].split("|")
    return listed.index(words) if words in listed else len(listed)


def steers(name: str) -> bool:
    """Whether a command is the angle of a rudder or a thruster, by its name."""
    return not STEERING.isdisjoint(read_name(name).words)


def is_propeller_speed(name: str) -> bool:
    """Whether a command is the speed of a propeller, by a unit in its name."""
    return not SPEEDS.isdisjoint(word.lower() for word in CAMEL.findall(name))


def is_measured(name: str) -> bool:
    """Whether a signal is measured rather than commanded, by its name."""
    measured, command = grade(name, Kind.MEASURED), grade(name, Kind.COMMAND)
    return measured is not None and (command is None or command < measured)
