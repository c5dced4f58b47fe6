# SPDX-License-Identifier: MIT
"""The Gazebo model: SDFormat's own checker passes it, and what its plugins would do is the core's motion."""

from dataclasses import replace
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from conftest import TABLE_II, make_model
from export_tools import boat, program
from programs import piped
from steered_boat import known

import seatrial
from seatrial import _core
from seatrial.boat.vehicle import vehicle_from
from seatrial.export import Hull, export
from seatrial.util.errors import ExportError, ModelError

HULL = Hull(10.0, 0.5, (0.6, 0.5, 0.2), (3.0, 4.0, 0.1))
NAMES = ("always_forward", "right_down", "ship")
GAINS = (1.1, 0.9, 1.05, 0.95)  # of right_down: the levels at full command


def written(folder, name, hull=HULL) -> Xml.Element:
    export(boat(name), "sdf", folder / "boat.sdf", hull=hull)
    return Xml.parse(folder / "boat.sdf").getroot().find("model")


def checked(path) -> tuple[int, str]:
    shown = piped(["ign", "sdf", "--check", str(path)])
    return shown.returncode, shown.stdout + shown.stderr


@pytest.mark.system
@pytest.mark.parametrize("name", NAMES)
def test_sdformats_own_checker_passes_it_and_not_a_broken_one(tmp_path, name):
    program("ign")
    written(tmp_path, name)
    assert "Valid." in checked(tmp_path / "boat.sdf")[1]
    broken = tmp_path / "broken.sdf"
    broken.write_text(
        (tmp_path / "boat.sdf").read_text().replace("<parent>base_link", "<parent>no_link")
    )
    code, words = checked(broken)
    assert code != 0
    assert "Valid." not in words


def numbers(element: Xml.Element, path: str) -> list[float]:
    return [float(x) for x in element.findtext(path).split()]


def inertias(model: Xml.Element) -> tuple[float, float, np.ndarray]:
    """Mass, yaw inertia about the origin and centre of mass, of all links together."""
    mass = inertia = 0.0
    moment = np.zeros(2)
    for link in model.findall("link"):
        own = float(link.findtext("inertial/mass"))
        at = np.array(numbers(link, "pose")[:2]) if link.find("pose") is not None else np.zeros(2)
        mass, moment = mass + own, moment + own * at
        inertia += float(link.findtext("inertial/inertia/izz")) + own * at @ at
    return mass, inertia, moment / mass


def engine(model: Xml.Element, nu: np.ndarray, f: np.ndarray, turned: float = 0.0) -> np.ndarray:
    """Accelerations of a rigid body under the plugins, by their documentation; nothing of seatrial's.

    f: shares of the thrust at full command, of the larger one of ahead and astern.
    turned: [rad] position of the joint that turns a thruster's link.

    Hydrodynamics: sum of c * nu_j, c * nu_j * nu_k, c * nu_j * |nu_k| and c * nu_dot_j, by names.
    """
    mass, inertia, _ = inertias(model)
    plugin = next(p for p in model.findall("plugin") if p.get("name").endswith("Hydrodynamics"))
    assert plugin.findtext("disable_coriolis") == "true"
    letters, speed = {"x": 0, "y": 1, "n": 2}, {"U": 0, "V": 1, "R": 2}
    force, late = np.zeros(3), np.zeros((3, 3))
    for element in plugin:
        axis, rest = letters.get(element.tag[0]), element.tag[1:]
        if axis is None or element.tag == "namespace":
            continue
        value = float(element.text)
        if rest.startswith("Dot"):
            late[axis, speed[rest[3]]] += value
        elif "abs" in rest:
            first, second = rest.split("abs")
            force[axis] += value * nu[speed[first]] * abs(nu[speed[second]])
        else:
            force[axis] += value * np.prod([nu[speed[letter]] for letter in rest])
    joints = {joint.findtext("child"): joint for joint in model.findall("joint")}
    pushing = [j for j in joints.values() if j.findtext("axis/xyz") == "1 0 0"]
    for k, joint in enumerate(pushing):
        gear = joints.get(joint.findtext("parent"))
        link = next(
            own for own in model.findall("link") if own.get("name") == joint.findtext("child")
        )
        x, y, *_, angle = numbers(link, "pose")
        if gear is not None:
            assert gear.findtext("parent") == "base_link"
            assert numbers(link, "pose") == numbers(
                model.find(f"link[@name='{gear.findtext('child')}']"), "pose"
            )
            angle += numbers(gear, "axis/xyz")[2] * turned
        full = next(
            max(float(p.findtext("max_thrust_cmd")), -float(p.findtext("min_thrust_cmd")))
            for p in model.findall("plugin") if p.findtext("joint_name") == joint.get("name")
        )  # fmt: skip
        push = full * f[k] * np.array([np.cos(angle), np.sin(angle)])
        force += [*push, x * push[1] - y * push[0]]
    u, v, r = nu
    force += [mass * v * r, -mass * u * r, 0.0]  # the engine's own, seen from the body
    return np.linalg.solve(np.diag([mass, mass, inertia]) - late, force)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("added", [(0.0, 0.0, 0.0), (3.0, 4.0, 0.1)])
def test_what_the_plugins_do_is_the_cores_acceleration_whatever_the_added_mass(
    tmp_path, name, added
):
    model = boat(name)
    described = written(tmp_path, name, replace(HULL, added=added))
    rng = np.random.default_rng(5)
    nu = rng.normal(size=(30, 3)) * [0.4, 0.3, 0.8]
    f = rng.uniform(-1.0, 1.0, (30, len(model.vehicle.actuators)))
    expected = _core.accelerations(
        model.structure.compiled,
        model.coefficients,
        nu,
        np.ascontiguousarray(f @ model.vehicle.mix.T),
    )
    shares = f / (GAINS if name == "right_down" else 1.0)
    found = [engine(described, a, b) for a, b in zip(nu, shares, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


# of the outboard's sway: X_F (10 + 3) kg = Y_F (10 + 9.5) kg, so that a turned thrust keeps its size
EVEN = replace(HULL, added=(3.0, 9.5, 0.1))


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
def test_a_thrust_that_an_angle_turns_is_a_thruster_on_a_joint(tmp_path, axes):
    model = known(axes=axes)
    export(model, "sdf", tmp_path / "boat.sdf", hull=EVEN)
    described = Xml.parse(tmp_path / "boat.sdf").getroot().find("model")
    rng = np.random.default_rng(5)
    nu = rng.normal(size=(30, 3)) * [0.4, 0.3, 0.8]
    for row, f, angle in zip(nu, rng.uniform(-1, 1, 30), rng.uniform(-0.7, 0.7, 30), strict=True):
        turned = np.array([f * np.cos(angle), f * np.sin(angle)])
        force = np.ascontiguousarray(turned @ model.vehicle.mix.T)
        expected = _core.accelerations(
            model.structure.compiled, model.coefficients, row[None], force[None]
        )[0]
        found = engine(described, row, np.array([f]), angle)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
    mass, inertia, _ = inertias(described)
    assert (mass, inertia) == pytest.approx((EVEN.mass, EVEN.inertia), rel=1e-12)
    (gear,) = [p for p in described.findall("plugin") if "JointPosition" in p.get("name")]
    assert gear.findtext("joint_name") == "helm_joint"
    assert float(gear.findtext("cmd_max")) == pytest.approx(np.radians(40.0))
    assert gear.findtext("use_velocity_commands") == "true"


@pytest.mark.system
def test_sdformats_own_checker_passes_a_turned_thruster(tmp_path):
    program("ign")
    export(known(), "sdf", tmp_path / "boat.sdf", hull=EVEN)
    assert "Valid." in checked(tmp_path / "boat.sdf")[1]


def test_a_turned_thrust_that_gazebo_has_not_is_one_clear_line(tmp_path):
    out = tmp_path / "boat.sdf"
    with pytest.raises(
        ExportError, match=r"7\.8 N ahead and 5\.6 N across.* give 9\.5 kg as"
    ) as caught:
        export(known(), "sdf", out, hull=HULL)
    assert "\n" not in str(caught.value)
    rudder = known(
        forces={"F_u": {"axis": "surge", "of": {"motor": 1}}, "F_r": {"axis": "yaw", "deflection": {"helm": -0.6}}},
        structure={
            "surge": ["X_u * u", "X_F * F_u"], "sway": ["Y_v * v"], "yaw": ["N_r * r", "N_F * F_r"],
        },
    )  # fmt: skip
    with pytest.raises(ExportError, match="helm is a rudder in the flow"):
        export(rudder, "sdf", out, hull=EVEN)
    assert not out.exists()


def test_mass_inertia_and_its_centre_are_those_that_were_given(tmp_path):
    mass, inertia, centre = inertias(written(tmp_path, "always_forward"))
    assert (mass, inertia) == pytest.approx((HULL.mass, HULL.inertia), rel=1e-12)
    assert np.abs(centre).max() < 1e-12


def test_thrusters_stay_where_they_were_measured_if_the_forces_fit_them(tmp_path):
    """Four at 45 degrees, each N newton, have X_F = Y_F = N sqrt(2) * 2 / m and the moment of their arms."""
    vehicle = seatrial.load_vehicle("mallard-mp")
    arm, thrust = np.hypot(0.2, 0.2), 1.5  # [m], [N]
    values = TABLE_II["AF"] | {
        # T's rows are the geometric ones over their norms: F_u = 1 is not f = 1
        "X_F": thrust * np.sqrt(2.0) / 10.0, "Y_F": thrust * np.sqrt(2.0) / 10.0, "N_F": thrust * 2 * arm / 0.5,
    }  # fmt: skip
    export(
        make_model(vehicle, values),
        "sdf",
        tmp_path / "boat.sdf",
        hull=replace(HULL, added=(0.0,) * 3),
    )
    model = Xml.parse(tmp_path / "boat.sdf").getroot().find("model")
    for link in model.findall("link")[1:]:
        placed = vehicle.file.thrusters[link.get("name")]
        expected = [placed.x, placed.y, 0, 0, 0, np.deg2rad(placed.angle_deg)]
        assert numbers(link, "pose") == pytest.approx(expected, abs=1e-9)
    full = [p.findtext("max_thrust_cmd") for p in model.findall("plugin")[1:]]
    assert [float(x) for x in full] == pytest.approx([thrust] * 4)


def test_the_comments_have_all_their_words(tmp_path):
    """A comment has a greatest length: what the user must know is not cut off."""
    export(known(), "sdf", tmp_path / "boat.sdf", hull=EVEN)
    text = (tmp_path / "boat.sdf").read_text()
    assert "so they do not determine the parts. -->" in text
    assert "Allocation, latency, dead zone, lag and slew rate are not included. -->" in text
    assert "Angles take rad on cmd_pos: helm (of motor). -->" in text


def test_full_command_has_the_gain_and_the_curve_of_its_direction(tmp_path):
    """Of four equal thrusters, 10 N each at level 1: at command 0.8, past the edges, and astern by the ratio."""
    described = boat("right_down")
    limited = described.vehicle.to_mapping()
    limited["allocation"] |= {"limit": 0.8}
    fit = np.sqrt(2.0) * 10.0 / HULL.effective[:2]
    model = make_model(
        vehicle_from(limited, "limited"), TABLE_II["AF"] | {"X_F": fit[0], "Y_F": fit[1]}
    )
    export(model, "sdf", tmp_path / "boat.sdf", hull=HULL)
    plugins = Xml.parse(tmp_path / "boat.sdf").getroot().findall("model/plugin")[1:]
    found = [[float(p.findtext(f"{end}_thrust_cmd")) for end in ("min", "max")] for p in plugins]
    # bow: (|f| - edge) / (1 - edge) to the power 1.4, astern 0.7 of it; stern: lines, F_3 astern 0.9
    ahead, astern = ((0.8 - 0.05) / 0.95) ** 1.4, 0.7 * ((0.8 - 0.11) / 0.89) ** 1.4
    levels = np.array([[-astern, ahead], [-astern, ahead], [-0.72, 0.8], [-0.8, 0.8]])
    np.testing.assert_allclose(found, 10.0 * np.array(GAINS)[:, None] * levels, rtol=1e-9)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.99, 1.01, 1.5, 3.0])
def test_what_is_refused_is_what_grows_from_step_to_step(tmp_path, share):
    """The plugin's way: the force of the acceleration of the step before."""
    hull = replace(HULL, added=(share * HULL.mass, 0.0, 0.0))
    acceleration = 0.0
    for _ in range(2000):
        acceleration = (1.0 - hull.added[0] * acceleration) / hull.mass
        acceleration = min(max(acceleration, -1e6), 1e6)
    settled = abs(acceleration - 1.0 / (hull.mass + hull.added[0])) < 1e-3
    out = tmp_path / "boat.sdf"
    assert settled == (share < 1.0)
    if settled:
        export(boat("always_forward"), "sdf", out, hull=hull)
        return
    with pytest.raises(ExportError, match=r"added mass is too large for Gazebo's plugin \(surge"):
        export(boat("always_forward"), "sdf", out, hull=hull)
    assert not out.exists()


def test_what_gazebo_has_not_is_one_clear_line(tmp_path):
    out = tmp_path / "boat.sdf"
    with pytest.raises(
        ExportError, match=r"per unit mass: give mass, inertia and the hull's size \(--mass"
    ):
        export(boat("always_forward"), "sdf", out)
    with pytest.raises(ExportError, match=r"no term like 'X_0' in surge"):
        export(boat("bare"), "sdf", out, hull=HULL)
    wrench = seatrial.load_vehicle("mallard-mp").to_mapping()
    wrench |= {"thrusters": {}, "allocation": {"scheme": "direct"}}
    direct = make_model(vehicle_from(wrench, "direct"), TABLE_II["AF"])
    with pytest.raises(ExportError, match="F_r gives a moment without a force"):
        export(direct, "sdf", out, hull=HULL)
    with pytest.raises(ExportError, match="less than that of the thrusters alone"):
        export(
            boat("always_forward"), "sdf", out, hull=replace(HULL, inertia=1e-6, added=(0.0,) * 3)
        )
    with pytest.raises(ModelError, match="unstable"):
        export(
            make_model(seatrial.load_vehicle("mallard-mp"), TABLE_II["AF"] | {"X_uu": 1.0}),
            "sdf",
            out,
            hull=HULL,
        )
    assert not out.exists()


@pytest.mark.parametrize(
    "wrong", [{"mass": -1.0}, {"inertia": 0.0}, {"size": (1.0, 1.0, 0.0)}, {"mass": np.nan}]
)
def test_a_hull_that_is_none_is_refused(wrong):
    with pytest.raises(ExportError, match="expected a positive number"):
        replace(HULL, **wrong)
    with pytest.raises(ExportError, match="added mass -1, 0, 0: expected numbers >= 0"):
        replace(HULL, added=(-1.0, 0.0, 0.0))
