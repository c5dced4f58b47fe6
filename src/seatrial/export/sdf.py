# SPDX-License-Identifier: MIT
"""A model for Gazebo (SDFormat 1.9): hull, thrusters, and plugins.

Plane motion: without gravity and waves; heave, roll and pitch are damped. Names of plugins and
parameters are those of Gazebo Garden to Harmonic.
"""

from xml.etree import ElementTree as Xml

import numpy as np

from seatrial.boat.model import Model
from seatrial.export.content import Content
from seatrial.export.gazebo import BASE_LINK, Gazebo, Gear, Propeller
from seatrial.export.hull import Hull
from seatrial.export.spelling import xml_comment
from seatrial.export.terms import number
from seatrial.util.errors import ExportError
from seatrial.util.frames import Axes

PROPELLER_MASS = 1e-4  # of the boat's mass, each; subtracted from the hull's
PROPELLER_SIZE = 0.02  # [m] radius
OUT_OF_PLANE_DAMPING = 10.0  # [1/s] damping of heave, roll and pitch over their inertia
WATER = 998.0  # [kg/m^3]


def text(model: Model, name: str, hull: Hull | None) -> bytes:
    """The file. Raises ExportError without mass and size, and for terms that Gazebo does not have."""
    if hull is None:
        raise ExportError(
            "a model for Gazebo is in N and kg, and coefficients are per unit mass: give mass, inertia and "
            "the hull's size (--mass KG --inertia KGM2 --size L W H)"
        )
    boat = Gazebo(Content(model, Axes.FLU), hull)
    boat.check_stable()
    root = Xml.Element("sdf", version="1.9")
    for words in _about(boat):
        root.append(Xml.Comment(f" {xml_comment(words)} "))
    own = Xml.SubElement(root, "model", name=name)
    _hull(own, boat)
    for propeller in boat.propellers:
        _link(own, propeller, boat)
    _hydrodynamics(own, name, boat)
    for propeller in boat.propellers:
        _thruster(own, name, propeller)
        if propeller.gear is not None:
            _gear(own, propeller.gear)
    Xml.indent(root)
    return bytes(Xml.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _about(boat: Gazebo) -> list[str]:
    """A comment each, as a comment has a greatest length."""
    content, hull = boat.content, boat.hull
    gears = ", ".join(f"{p.gear.name} (of {p.name})" for p in boat.propellers if p.gear)
    return [
        f"{content.vehicle_name} by {content.source}",
        f"Mass {hull.mass:g} kg, inertia {hull.inertia:g} kg m^2, added mass {hull.added[0]:g}, "
        f"{hull.added[1]:g} kg, {hull.added[2]:g} kg m^2 as given by the user: coefficients are per unit of "
        "the sum, so they do not determine the parts.",
        "Thrusters take N on cmd_thrust; full command ahead and astern give max_thrust_cmd and min_thrust_cmd. "
        "Allocation, latency, dead zone, lag and slew rate are not included.",
        *([f"Angles take rad on cmd_pos: {gears}."] if gears else []),
    ]


def _element(parent: Xml.Element, path: str, value: str) -> None:
    """Elements a/b/c with a text in the last."""
    for tag in path.split("/"):
        found = parent.find(tag)
        parent = Xml.SubElement(parent, tag) if found is None else found
    parent.text = value


def _mass(boat: Gazebo) -> float:
    return PROPELLER_MASS * boat.hull.mass


def _hull(model: Xml.Element, boat: Gazebo) -> None:
    """Mass and inertia less those of the propellers, so that the sum is the given one."""
    hull, own = boat.hull, _mass(boat)
    length, width, height = hull.size
    links = [(p, 2 if p.gear else 1) for p in boat.propellers]
    offset = sum(n * (own * (p.x**2 + p.y**2) + _spin(own)) for p, n in links)
    mass, inertia = hull.mass - own * sum(n for _, n in links), hull.inertia - offset
    if inertia <= 0:
        raise ExportError(
            f"inertia {hull.inertia:g} kg m^2 is less than that of the thrusters alone; expected about "
            f"{hull.mass * (length**2 + width**2) / 12:.2g} for a box of {hull.mass:g} kg"
        )
    link = Xml.SubElement(model, "link", name=BASE_LINK)
    _element(link, "gravity", "false")
    flat = length**2 + width**2  # roll and pitch inertia of a box with this yaw inertia
    roll, pitch = inertia * (width**2 + height**2) / flat, inertia * (length**2 + height**2) / flat
    _inertial(link, mass, (roll, pitch, inertia))
    for kind in ("collision", "visual"):
        shape = Xml.SubElement(link, kind, name=f"hull_{kind}")
        _element(shape, "geometry/box/size", " ".join(map(number, hull.size)))


def _spin(mass: float) -> float:
    """Inertia of a propeller, a ball."""
    return 0.4 * mass * PROPELLER_SIZE**2


def _inertial(link: Xml.Element, mass: float, diagonal: tuple[float, float, float]) -> None:
    _element(link, "inertial/mass", number(mass))
    for name, value in zip(("ixx", "iyy", "izz"), diagonal, strict=True):
        _element(link, f"inertial/inertia/{name}", number(value))


def _link(model: Xml.Element, propeller: Propeller, boat: Gazebo) -> None:
    """A propeller that turns about its thrust axis; below a link that turns that axis, where it has a gear."""
    gear = propeller.gear
    if gear is not None:
        _body(model, gear.name, propeller, boat)
        _joint(model, gear.joint, BASE_LINK, gear.name, f"0 0 {number(gear.side)}")
    link = _body(model, propeller.name, propeller, boat)
    shape = Xml.SubElement(link, "visual", name="propeller")
    _element(shape, "geometry/sphere/radius", number(PROPELLER_SIZE))
    parent = BASE_LINK if gear is None else gear.name
    _joint(model, propeller.joint, parent, propeller.name, "1 0 0")


def _body(model: Xml.Element, name: str, propeller: Propeller, boat: Gazebo) -> Xml.Element:
    """A small link at the propeller."""
    link = Xml.SubElement(model, "link", name=name)
    _element(link, "gravity", "false")
    _element(
        link, "pose", f"{number(propeller.x)} {number(propeller.y)} 0 0 0 {number(propeller.angle)}"
    )
    _inertial(link, _mass(boat), (_spin(_mass(boat)),) * 3)
    return link


def _joint(model: Xml.Element, name: str, parent: str, child: str, axis: str) -> None:
    joint = Xml.SubElement(model, "joint", name=name, type="revolute")
    _element(joint, "parent", parent)
    _element(joint, "child", child)
    _element(joint, "axis/xyz", axis)


def _plugin(model: Xml.Element, file: str, kind: str) -> Xml.Element:
    return Xml.SubElement(
        model, "plugin", filename=f"gz-sim-{file}-system", name=f"gz::sim::systems::{kind}"
    )


def _hydrodynamics(model: Xml.Element, name: str, boat: Gazebo) -> None:
    plugin = _plugin(model, "hydrodynamics", "Hydrodynamics")
    _element(plugin, "link_name", BASE_LINK)
    _element(plugin, "namespace", name)
    # the model has all terms: the plugin's own are disabled
    _element(plugin, "disable_coriolis", "true")
    _element(plugin, "water_density", number(WATER))
    for parameter, value in boat.hydrodynamics.items():
        _element(plugin, parameter, number(value))
    length, width, height = boat.hull.size
    damped = {"zW": 1.0, "kP": (width**2 + height**2) / 12, "mQ": (length**2 + height**2) / 12}
    for parameter, share in damped.items():
        _element(plugin, parameter, number(-OUT_OF_PLANE_DAMPING * boat.hull.mass * share))


def _thruster(model: Xml.Element, name: str, propeller: Propeller) -> None:
    plugin = _plugin(model, "thruster", "Thruster")
    astern, ahead = propeller.reach
    _element(plugin, "namespace", name)
    _element(plugin, "joint_name", propeller.joint)
    _element(plugin, "thrust_coefficient", "1.0")
    _element(plugin, "fluid_density", number(WATER))
    _element(plugin, "propeller_diameter", number(float(np.round(2 * PROPELLER_SIZE, 6))))
    _element(plugin, "velocity_control", "true")
    _element(plugin, "max_thrust_cmd", number(ahead))
    _element(plugin, "min_thrust_cmd", number(astern))


def _gear(model: Xml.Element, gear: Gear) -> None:
    """The joint turns to the angle on cmd_pos, at its rate limit at most."""
    plugin = _plugin(model, "joint-position-controller", "JointPositionController")
    _element(plugin, "joint_name", gear.joint)
    _element(plugin, "use_velocity_commands", "true")
    if gear.rate is not None:
        _element(plugin, "cmd_max", number(gear.rate))
        _element(plugin, "cmd_min", number(-gear.rate))
