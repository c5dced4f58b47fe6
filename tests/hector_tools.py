# SPDX-License-Identifier: MIT
"""Hector mapping (Kohlbrecher et al. 2011), the paper's SLAM [14]: where it is, and how it is started."""

import os
import subprocess
from pathlib import Path

import seatrial
from seatrial.util.files import read_yaml

VARIABLE = "SEATRIAL_HECTOR"  # its program, or the folder that it was built in
PLACE = Path("lib") / "hector_mapping" / "hector_mapping"
NODE = "/hector_mapping"
POSE = "/slam_out_pose"
# those of its own mapping_default.launch, on a map of 26 m
PARAMETERS = {
    "map_resolution": 0.05, "map_size": 512, "map_multi_res_levels": 2,
    "map_update_distance_thresh": 0.4, "map_update_angle_thresh": 0.06,
    "laser_z_min_value": -1.0, "laser_z_max_value": 1.0,
    "map_frame": "map", "base_frame": "base_link",
}  # fmt: skip


def program() -> Path | None:
    """Its program, by the environment."""
    given = os.environ.get(VARIABLE)
    if not given:
        return None
    path = Path(given)
    if path.is_file():
        return path
    return next((found for found in path.rglob(str(PLACE)) if found.is_file()), None)


def vehicle(folder: Path) -> Path:
    """The bundled boat, whose poses are Hector's: a vehicle file in the folder."""
    path = folder / "vehicle.yaml"
    text = (Path(seatrial.__file__).parent / "data" / "vehicles" / "mallard-mp.yaml").read_text()
    path.write_text(text.replace("topic: /slam/pose", f"topic: {POSE}"))
    assert read_yaml(path)["pose"]["topic"] == POSE
    return path


def start(ros: object, **parameters: object) -> subprocess.Popen:
    """Hector mapping below a master, with its own defaults but for these."""
    given = {**PARAMETERS, **parameters}
    arguments = [f"_{name}:={_word(value)}" for name, value in given.items()]
    return ros.start(str(program()), f"__name:={NODE[1:]}", *arguments)


def packages(own: Path, built: Path) -> dict[str, str]:
    """The environment with which roslaunch finds Hector, and our package in a folder, built in another."""
    prefix = program().parents[2]
    mark = prefix / ".catkin"  # of a build folder: where its sources are
    sources = mark.read_text().split(";") if mark.exists() else []
    return {
        "ROS_PACKAGE_PATH": ":".join([str(own), *sources, str(prefix / "share")]),
        "CMAKE_PREFIX_PATH": f"{built}:{prefix}",
    }


def _word(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
