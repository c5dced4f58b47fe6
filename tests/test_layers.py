# SPDX-License-Identifier: MIT
"""Imports go down only, and the slow ones stay inside the functions that need them."""

import ast
import graphlib
import subprocess
import sys
from pathlib import Path

import seatrial

ROOT = Path(seatrial.__file__).parent
LAYERS = [  # from the bottom; a module may import only from layers below its own, or from its own
    {"_core", "errors"},
    {"bootstrap", "distributions", "files", "frames", "parallel", "progress", "schema", "statistics", "words"},
    {"faults", "streams"},
    {"allocation", "chain", "plan", "recording", "structure"},
    {"filter_noise", "noise", "vehicle", "velocity"},
    {"model"},
    {"allocate", "causal", "doubt", "excitation", "foreseen", "identifiability", "operators", "predict", "residuals", "sanity", "signs", "stencil_noise", "stretches"},
    {"against", "identify", "inspect", "odometer", "predictor", "simulate", "validate", "validate_text"},
    {"advice", "compare", "control", "live", "mimic", "sim"},
    {"select"},
    {"io", "report"},
    {"export", "init"},
    {"demo", "mpc"},
    {"commands"},
    {"cli"},
]  # fmt: skip
LEVEL = {name: i for i, layer in enumerate(LAYERS) for name in layer}
EDGES = {
    "plotly",
    "resvg_py",
    "rosbags",
    "lz4",
    "apsw",
    "backports",
    "casadi",
    "scipy",
    "matplotlib",
    "pandas",
}


def _imports(path: Path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            if node.module == "seatrial":
                yield from (f"seatrial.{alias.name}" for alias in node.names)
            else:
                yield node.module or ""


def _module(path: Path) -> str:
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


def test_every_module_has_a_layer():
    found = {_module(p) for p in ROOT.rglob("*.py")} - {"__init__"}
    assert found | {"_core"} == set(LEVEL)


def test_imports_go_down_only():
    wrong = []
    for path in ROOT.rglob("*.py"):
        if path == ROOT / "__init__.py":
            continue
        own = _module(path)
        for name in _imports(path):
            parts = name.split(".")
            if parts[0] != "seatrial" or len(parts) == 1:
                continue
            if LEVEL[parts[1]] > LEVEL[own]:
                wrong.append(f"{path.relative_to(ROOT)} imports {name}")
    assert not wrong, wrong


def test_modules_do_not_import_each_other_in_circles():
    graph = {name: set() for name in LEVEL}
    for path in ROOT.rglob("*.py"):
        if path != ROOT / "__init__.py":
            found = (n.split(".")[1] for n in _imports(path) if n.startswith("seatrial."))
            graph[_module(path)] |= set(found) - {_module(path)}
    assert len(tuple(graphlib.TopologicalSorter(graph).static_order())) == len(LEVEL)


def test_inner_layers_do_not_import_plotting_or_bag_libraries():
    for path in ROOT.rglob("*.py"):
        if LEVEL.get(_module(path), 99) < LEVEL["io"]:
            assert not EDGES & {n.split(".")[0] for n in _imports(path)}, path


def test_importing_seatrial_is_light():
    code = (
        "import sys, seatrial; print([m for m in ('scipy','plotly','pandas') if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"
