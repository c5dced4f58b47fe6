# SPDX-License-Identifier: MIT
"""Parameter files for ROS: the odometry node's, and the boat's numbers for other nodes."""

from pathlib import Path
from typing import Any

from seatrial.export.content import Content
from seatrial.export.spelling import identifiers, line
from seatrial.util.errors import ExportError
from seatrial.util.files import dump_yaml

ODOMETRY_NODE = "seatrial_odometry"
USAGE = {
    1: f"rosparam load FILE, then rosrun {ODOMETRY_NODE} odometry __name:={ODOMETRY_NODE}",
    2: f"ros2 run {ODOMETRY_NODE} odometry --ros-args -r __node:={ODOMETRY_NODE} --params-file FILE",
}


def text(content: Content, model_path: Path | None, ros: int) -> str:
    """The file for ROS 1 or ROS 2. The node needs `model`; its other parameters have defaults."""
    if model_path is None:
        raise ExportError("the node reads model.yaml: give its path (model_path)")
    parameters: dict[str, Any] = {"model": str(model_path.resolve()), "boat": _boat(content)}
    file = {ODOMETRY_NODE: parameters if ros == 1 else {"ros__parameters": parameters}}
    about = line(f"{content.vehicle_name} by {content.source}")
    head = f"# ROS {ros} parameters of {about}: {USAGE[ros]}\n"
    units = (
        "# boat: axes as stated, SI; coefficients per unit mass and inertia; matrices row by row\n"
    )
    return head + units + dump_yaml(file)


def _angles(content: Content) -> dict[str, Any]:
    """The thrust that each angle turns, and D row by row; nothing without angles."""
    if not content.angles:
        return {}
    keys = identifiers([content.actuators[k].name for k, _ in content.angles])
    turned = {
        keys[content.actuators[k].name]: content.actuators[thrust].name
        for k, thrust in content.angles
    }
    return {"steers": turned, "deflection": content.deflection.ravel().tolist()}


def _boat(content: Content) -> dict[str, Any]:
    """Parameters without nested lists, which ROS 2 does not support."""
    own = set(content.structure.coefficients)
    keys = identifiers(content.sources)
    errors = {keys[name]: content.errors[source] for name, source in content.sources.items()}
    limit = {} if content.limit is None else {"limit": float(content.limit)}
    constants = {
        keys[name]: content.values[source]
        for name, source in content.sources.items()
        if name not in own
    }
    return {
        "name": content.vehicle_name,
        "axes": content.axes.value,
        "inputs": list(content.inputs),
        "actuators": [a.name for a in content.actuators],
        "forces": list(content.forces),
        "coefficients": {keys[n]: value for n, value in content.values.items() if n in own},
        **({"constants": constants} if constants else {}),
        "standard_errors": errors,
        "allocation": {
            "scheme": content.scheme.value,
            "inverse": content.inverse.ravel().tolist(),
            "offset": float(content.offset),
            **limit,
        },
        "mix": content.mix.ravel().tolist(),
        **_angles(content),
    }
