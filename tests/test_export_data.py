# SPDX-License-Identifier: MIT
"""JSON, ROS parameters, LaTeX: what reads them finds the model again."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from conftest import ROOT, TABLE_II, make_model
from export_tools import BOATS, boat, core_states, drive
from programs import piped

from seatrial import _core
from seatrial.boat.actuators import STAGES, USES
from seatrial.boat.vehicle import vehicle_from
from seatrial.export import export
from seatrial.util.errors import ExportError

SYSTEM_PYTHON = "/usr/bin/python3"
FACTORS = ("u", "v", "r", "|u|", "|v|", "|r|")
SCHEMES = ("direct", "moore-penrose", "always-forward")
AXES = ("surge", "sway", "yaw")


def core_from(said: dict) -> tuple[_core.Boat, _core.Chain, np.ndarray]:
    """The core's boat, chain and constants from the JSON alone."""
    own = [n for n, p in said["parameters"].items() if p["of"] == "boat"]
    constants = [n for n, p in said["parameters"].items() if p["of"] == "actuators"]
    codes = {name: i for i, name in enumerate((*FACTORS, *(f["name"] for f in said["forces"])))}
    terms = [
        (
            AXES.index(t["axis"]),
            own.index(t["coefficient"]) if t["coefficient"] else -1,
            t["number"],
            AXES.index(t["acceleration"]) if t["acceleration"] else -1,
            [codes[f] for f in t["factors"]],
        )
        for t in said["terms"]
    ]
    value = {n: p["value"] for n, p in said["parameters"].items()}
    structure = _core.Structure(terms, len(own), len(said["forces"]))
    core = _core.Boat(
        structure, np.array([value[n] for n in own]), 0, said["integration"]["longest_step"]
    )
    places = {a["name"]: k for k, a in enumerate(said["actuators"])}
    rows = np.full((len(places), len(STAGES) + len(USES)), -1, dtype=np.int32)
    for row, actuator in zip(rows, said["actuators"], strict=True):
        for stage, name in actuator["constants"].items():
            row[STAGES.index(stage)] = constants.index(name)
        scale, pair = actuator["scale"], actuator["pair"]
        row[len(STAGES)] = -1 if scale is None else list(said["scales"]).index(scale)
        row[len(STAGES) + 1] = 1 if actuator["tabulated"] else -1
        if pair:
            row[len(STAGES) + 2 : len(STAGES) + 5] = (
                places[pair["partner"]],
                pair["across"],
                pair["mirrored"],
            )
        if actuator["steers"]:
            row[len(STAGES) + USES.index("steers")] = places[actuator["steers"]]
    allocation = said["allocation"]
    chain = _core.Chain(
        SCHEMES.index(allocation["scheme"]), np.array(allocation["inverse"]), allocation["offset"],
        np.inf if allocation["limit"] is None else allocation["limit"], np.array(said["mix"]), rows, len(constants),
        np.array(list(said["scales"].values())), np.array(said["table"], dtype=float).reshape(-1, 2),
        np.array(said["deflection"]),
    )  # fmt: skip
    return core, chain, np.array([value[n] for n in constants])


@pytest.mark.parametrize("name", BOATS)
def test_a_boat_built_from_the_json_alone_moves_along_s7_as_the_model_does(tmp_path, name):
    model, own = boat(name), drive(name)
    export(model, "json", tmp_path / "boat.json")
    said = json.loads((tmp_path / "boat.json").read_text(), parse_constant=pytest.fail)
    core, chain, constants = core_from(said)
    if (
        said["allocation"]["scheme"] == "direct"
    ):  # the core takes direct commands as they are: turn them here
        commands = own.commands @ np.array(said["allocation"]["inverse"]).T
    else:
        commands = own.commands
    scale_t = own.t if said["scales"] else np.zeros(0)
    trace = _core.ThrustTrace(
        chain, constants, own.t, np.ascontiguousarray(commands), scale_t, own.scales[: len(scale_t)]
    )
    states, _ = _core.simulate(core, trace, np.zeros(6), own.t)
    expected = core_states(model, own)
    # a plant breaks at every command, a recording where it changes: hence not closer
    np.testing.assert_allclose(states, expected, rtol=0, atol=1e-7)


def test_json_holds_errors_intervals_covariance_and_provenance(tmp_path):
    model = boat("right_down")
    export(model, "json", tmp_path / "boat.json")
    said = json.loads((tmp_path / "boat.json").read_text())
    drag, given = said["parameters"]["X_uu"], said["parameters"]["lag.bow"]
    assert drag["interval_95"] == pytest.approx(
        [-1.74 - 1.96 * 0.174, -1.74 + 1.96 * 0.174], rel=1e-4
    )
    assert (given["standard_error"], given["interval_95"], given["unit"]) == (None, None, "s")
    names = list(said["parameters"])
    error = np.sqrt(said["covariance"][names.index("X_uu")][names.index("X_uu")])
    assert error == pytest.approx(drag["standard_error"])
    assert said["parameters"]["N_uu"]["value"] == -model.values["N_uu"]  # forward-right-down
    assert said["estimator"]["method"] == "given"


def ros_file(folder, name, ros) -> dict:
    out = folder / f"ros{ros}.yaml"
    export(boat(name), "ros", out, model_path=folder / "model.yaml", ros=ros)
    return yaml.safe_load(out.read_text())


def test_ros_parameters_are_those_that_the_node_knows(tmp_path):
    declared = re.findall(
        r'Parameter\{"(\w+)"', (ROOT / "ros/common/include/seatrial_ros/settings.hpp").read_text()
    )
    for ros in (1, 2):
        node = ros_file(tmp_path, "ship", ros)["seatrial_odometry"]
        parameters = node if ros == 1 else node["ros__parameters"]
        assert set(parameters) - {"boat"} <= set(declared)
        assert parameters["model"] == str(tmp_path / "model.yaml")
        assert parameters["boat"]["coefficients"]["X_uu"] == -0.5
        assert parameters["boat"]["constants"]["latency_surge"] == 0.21
    with pytest.raises(ExportError, match="give its path"):
        export(boat("ship"), "ros", tmp_path / "ros.yaml")


def test_ros_parameters_and_a_table_name_both_of_two_equal_edges(tmp_path):
    """One constant is both edges of a dead zone; another node, or a reader, looks for each by its name."""
    group = {"name": "stern", "dead_zone": {"forward": 0.08, "reverse": "forward"}, "lag": 0.1}
    content = boat("always_forward").vehicle.to_mapping() | {"chain": [group]}
    model = make_model(vehicle_from(content, "stern"), TABLE_II["AF"])
    covariance = model.covariance.copy()
    edge = model.parameters.index("edge_forward.stern")
    covariance[edge, edge] = 0.01**2
    model = replace(model, covariance=covariance)
    export(model, "ros", tmp_path / "b.yaml", model_path=tmp_path / "m")
    stated = yaml.safe_load((tmp_path / "b.yaml").read_text())
    found = stated["seatrial_odometry"]["ros__parameters"]["boat"]
    assert found["constants"] == {
        "edge_forward_stern": 0.08, "edge_reverse_stern": 0.08, "lag_stern": 0.1,
    }  # fmt: skip
    errors = [found["standard_errors"][f"edge_{way}_stern"] for way in ("forward", "reverse")]
    assert errors == pytest.approx([0.01, 0.01])
    export(model, "latex", tmp_path / "b.tex")
    rows = [line.split("&") for line in (tmp_path / "b.tex").read_text().splitlines()]
    ahead, astern = (
        [cell.strip() for cell in row[1:]] for row in rows if row[0].startswith("edge")
    )
    assert ahead == astern
    assert ahead[0] == "$0.08000$"


@pytest.mark.parametrize("name", BOATS)
def test_what_ros_2_can_not_take_is_not_in_it(tmp_path, name):
    """Its parameters are numbers, words, and lists of one kind; no null, no list in a list, no dot in a name."""

    def look(value):
        if isinstance(value, dict):
            for key, inner in value.items():
                assert re.fullmatch(r"\w+", key)
                look(inner)
        elif isinstance(value, list):
            assert len({type(x) for x in value}) == 1
            assert isinstance(value[0], (float, str))
        else:
            assert isinstance(value, (float, str))

    look(ros_file(tmp_path, name, 2))


@pytest.mark.system
def test_ros_1s_own_reader_finds_the_matrix_again(tmp_path):
    code = "import json, sys, rosparam; print(json.dumps(rosparam.load_file(sys.argv[1], default_namespace='/')))"
    ros_file(tmp_path, "right_down", 1)
    try:
        done = piped([SYSTEM_PYTHON, "-c", code, str(tmp_path / "ros1.yaml")])
    except FileNotFoundError:
        pytest.skip("no system Python")
    if "No module named 'rosparam'" in done.stderr:
        pytest.skip("Debian's ROS 1 is not installed")
    ((found, place),) = json.loads(done.stdout)
    mix = np.array(found["seatrial_odometry"]["boat"]["mix"]).reshape(3, 4)
    inverse = np.array(found["seatrial_odometry"]["boat"]["allocation"]["inverse"]).reshape(4, 3)
    assert place == "/"
    np.testing.assert_allclose(mix @ inverse, np.eye(3), atol=1e-9)


def test_latex_has_equations_and_every_parameter_with_its_interval(tmp_path):
    model = boat("right_down")
    export(model, "latex", tmp_path / "boat.tex")
    text = (tmp_path / "boat.tex").read_text()
    assert r"\dot u &= v \, r + X_{\mathrm{u}} \, u" in text
    for kind in ("align*", "tabular"):
        assert text.count(rf"\begin{{{kind}}}") == text.count(rf"\end{{{kind}}}") == 1
    rows = [line for line in text.splitlines() if line.endswith(r"\\") and line.count(" & ") == 5][
        1:
    ]
    assert len(rows) == len(model.parameters)
    values = [float(row.split(" & ")[1].strip("$")) for row in rows]
    expected = in_own_values(model)
    assert values == pytest.approx(expected, rel=1e-3)
    assert text.count("{") == text.count("}")
    assert r"$X_{\mathrm{uu}}$ & $-1.740$ & $0.17$ & $-2.08$ to $-1.40$ & 1/m" in text


def in_own_values(model) -> list[float]:
    """By the rule of docs/conventions.md: of the paper's coefficients N_ud and N_uu change sign."""
    turned = {"N_ud", "N_uu"}
    values = [*model.coefficients, *model.constants]
    return [-v if n in turned else v for n, v in zip(model.parameters, values, strict=True)]
