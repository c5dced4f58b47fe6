# SPDX-License-Identifier: MIT
"""Exports of motion-capture systems, as Motive, QTM and Nexus lay them out, of bodies whose motion is known."""

from dataclasses import dataclass
from zlib import crc32

import numpy as np
from init_tools import proposed
from logs import drive, half
from scipy.spatial.transform import Rotation
from sheets import sheet

import seatrial

RATE = 30.0  # [Hz]
LENGTHS = {"Meters": 1.0, "Centimeters": 1e2, "Millimeters": 1e3}
Y_UP = Rotation.from_matrix([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # z-up coordinates to y-up ones
DRAUGHT = 0.05  # [m] height of a body


@dataclass(frozen=True)
class Body:
    """A rigid body in z-up axes."""

    name: str
    place: np.ndarray  # (n, 3) [m]
    turned: Rotation  # (n,)
    seen: np.ndarray  # (n,)


def body(name, pose, *, tilt=0.02, lost=(), seed=0):
    """A body that heels and pitches by `tilt` [rad] about its heading. pose (n, 3): x, y, psi."""
    rng = np.random.default_rng(seed)
    n = len(pose)
    heel, pitch = tilt * np.sin(np.arange(n) / 9.0), tilt * np.cos(np.arange(n) / 14.0)
    height = DRAUGHT + 0.002 * rng.normal(size=n)
    seen = np.ones(n, dtype=bool)
    seen[list(lost)] = False
    turned = Rotation.from_euler("ZYX", np.column_stack([pose[:, 2], pitch, heel]))
    return Body(name, np.column_stack([pose[:, :2], height]), turned, seen)


def _in_axes(one, up):
    """Positions (n, 3) and rotations in the axes of the file."""
    if up == "z":
        return one.place, one.turned
    return Y_UP.apply(one.place), Y_UP * one.turned * Y_UP.inv()


def _cells(values, seen, digits, lost=""):
    """Texts (n, k) of numbers; `lost` where the body is not seen."""
    out = np.array([[f"{v:.{digits}f}" for v in row] for row in values], dtype=object)
    out[~seen] = lost
    return out


def _write(path, head, rows, mark, newline="\n"):
    lines = [*head, *(mark.join(row) for row in rows)]
    path.write_text(newline.join(lines) + newline, newline="")
    return path


def motive(path, t, bodies, *, up="y", length="Meters", rotation="Quaternion", version="1.23",
           begun="2023-05-11 02.31.05.123 PM", markers=2, error=True, space="Global"):  # fmt: skip
    """OptiTrack Motive: metadata in one line; rows of types, names, IDs, (parents,) quantities, axes."""
    n, columns = len(t), []  # type, name, quantity, axis, cells (n,)
    for one in bodies:
        place, turned = _in_axes(one, up)
        if rotation == "Quaternion":
            angles, axes = turned.as_quat(), "XYZW"
        else:
            angles, axes = turned.as_euler(rotation, degrees=True), rotation
            order = [rotation.index(a) for a in "XYZ"]
            angles, axes = angles[:, order], "XYZ"
        q, p = _cells(angles, one.seen, 6), _cells(LENGTHS[length] * place, one.seen, 6)
        columns += [("Rigid Body", one.name, "Rotation", a, q[:, i]) for i, a in enumerate(axes)]
        columns += [("Rigid Body", one.name, "Position", a, p[:, i]) for i, a in enumerate("XYZ")]
        if error:
            e = _cells(np.full((n, 1), 0.0003), one.seen, 6)
            columns.append(("Rigid Body", one.name, "Mean Marker Error", "", e[:, 0]))
        for kind in ("Rigid Body Marker", "Marker"):
            columns += [
                (kind, f"{one.name}:Marker{k}", "Position", a, p[:, i])
                for k in range(markers) for i, a in enumerate("XYZ")
            ]  # fmt: skip
    if not bodies:
        lone = _cells(np.ones((n, 3)), np.ones(n, bool), 6)
        columns += [
            ("Marker", f"Unlabeled {k}", "Position", a, lone[:, i])
            for k in range(markers) for i, a in enumerate("XYZ")
        ]  # fmt: skip
    head = [
        f"Format Version,{version},Take Name,trial,Take Notes,,Capture Frame Rate,120.000000,Export Frame Rate,"
        f"120.000000,Capture Start Time,{begun},Capture Start Frame,0,Total Frames in Take,{n},Total Exported "
        f"Frames,{n},Rotation Type,{rotation},Length Units,{length},Coordinate Space,{space}",
        "",
        ",".join(["", "Type", *(c[0] for c in columns)]),
        ",".join(["", "Name", *(c[1] for c in columns)]),
        ",".join(["", "ID", *(f'"{crc32(c[1].encode()):X}"' for c in columns)]),
        *([",".join(["", "Parent", *("" for _ in columns)])] if version != "1.23" else []),
        ",".join(["", "", *(c[2] for c in columns)]),
        ",".join(["Frame", "Time (Seconds)", *(c[3] for c in columns)]),
    ]
    rows = zip(
        map(str, range(n)), (f"{x:.6f}" for x in t), *(c[4] for c in columns), strict=True
    )  # fmt: skip
    return _write(path, head, rows, ",", "\r\n")


def qualisys(path, rate, bodies, *, frames=True, time=True, lost="0.00000", matrix=True,
             begun="2020-01-22, 17:47:17\t22107.99"):  # fmt: skip
    """Qualisys QTM: a key a line; millimetres, roll, pitch and yaw [deg], the matrix column by column."""
    n = len(bodies[0].place)
    names, columns = [], []
    for one in bodies:
        angles = one.turned.as_euler("XYZ", degrees=True)
        parts = [1e3 * one.place, angles, np.full((n, 1), 1.5)]
        axes = ["X", "Y", "Z", "Roll", "Pitch", "Yaw", "Residual"]
        if matrix:
            parts.append(one.turned.as_matrix().transpose(0, 2, 1).reshape(n, 9))
            axes += [f"Rot[{i}]" for i in range(9)]
        names += [f"{one.name} {axes[0]}", *axes[1:]]
        columns.append(_cells(np.column_stack(parts), one.seen, 5, lost))
    index = [*(["Frame"] if frames else []), *(["Time"] if time else [])]
    head = [
        f"NO_OF_FRAMES\t{n}", "NO_OF_CAMERAS\t8", f"NO_OF_BODIES\t{len(bodies)}", f"FREQUENCY\t{rate}",
        "NO_OF_ANALOG\t0", "ANALOG_FREQUENCY\t0", "DESCRIPTION\t--", f"TIME_STAMP\t{begun}", "DATA_INCLUDED\t6D",
        "EVENT\tstart of drive\t1\t0.00000",
        "\t".join(["BODY_NAMES", *(one.name for one in bodies)]), "\t".join([*index, *names, ""]),
    ]  # fmt: skip
    stamps = [
        *([[str(i + 1) for i in range(n)]] if frames else []),
        *([[f"{i / rate:.5f}" for i in range(n)]] if time else []),
    ]
    rows = zip(*stamps, *np.column_stack(columns).T, [""] * n, strict=True)
    return _write(path, head, rows, "\t", "\r\n")


def vicon(path, rate, bodies, *, kind="Segments", angle="deg", quaternion=False, more=False):
    """Vicon: the kind, the rate, names over their first column, axes, units; then another section."""
    n, names, axes, units, columns = len(bodies[0].place), [], [], [], []
    for one in bodies:
        turned = (
            one.turned.as_quat()
            if quaternion
            else one.turned.as_euler("XYZ", degrees=angle == "deg")
        )
        own = ["RX", "RY", "RZ", *(["RW"] if quaternion else []), "TX", "TY", "TZ"]
        names += [f"{one.name}:{one.name}", *[""] * (len(own) - 1)]
        axes += own
        units += [*(["" if quaternion else angle] * (len(own) - 3)), "mm", "mm", "mm"]
        columns.append(_cells(np.column_stack([turned, 1e3 * one.place]), one.seen, 6))
    head = [
        kind, f"{rate}", ",".join(["", "", *names]), ",".join(["Frame", "Sub Frame", *axes]),
        ",".join(["", "", *units]),
    ]  # fmt: skip
    rows = [
        list(row) for row in zip([str(i + 1) for i in range(n)], ["0"] * n, *np.column_stack(columns).T, strict=True)
    ]  # fmt: skip
    tail = [
        [""],
        ["Trajectories"],
        ["100"],
        ["", "", "boat:a"],
        ["Frame", "Sub Frame", "X"],
        ["1", "0", "2"],
    ]
    return _write(path, head, [*rows, *(tail if more else [])], ",")


def minute():
    """A minute of a boat, whose poses are the truth here."""
    return drive(60.0, rate=RATE, sticks=half)


def far(pose):
    """The same motion over metres, through all headings; (n, 3)."""
    t = np.arange(len(pose)) / RATE
    psi = 0.4 * t + 0.3 * np.sin(t)
    steps = 0.3 / RATE * np.column_stack([np.cos(psi), np.sin(psi)])
    return np.column_stack([np.cumsum(steps, axis=0), psi])


def commands(log, folder, clock=lambda t: t):
    """The table of the commands beside the take."""
    t = clock(log.command_t)
    sheet(folder / "commands.csv", "t,F_u,F_v,F_r", t, log.command, form="%.6f")


def taken(log, folder, *bodies, clock=lambda t: t, **how):
    """A folder with the take of these bodies, by default a boat's far motion, and the commands."""
    folder.mkdir(exist_ok=True)
    motive(folder / "take.csv", log.pose_t, bodies or [body("boat", far(log.pose))], **how)
    commands(log, folder, clock)
    return folder


def read(folder, **choices):
    """The proposal, its vehicle file and the recording by it."""
    proposal, vehicle = proposed(folder, **choices)
    return proposal, vehicle, seatrial.read(folder, vehicle)
