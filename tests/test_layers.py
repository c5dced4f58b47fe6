# SPDX-License-Identifier: MIT
"""Imports go down only, and the slow ones stay inside the functions that need them."""

import ast
import graphlib
import importlib
import subprocess
import sys
from pathlib import Path

import seatrial

ROOT = Path(seatrial.__file__).parent
ROOMS = (  # from the bottom; a room imports only from rooms before it, and from itself
    "_core", "util", "boat", "recording", "evaluation", "onboard", "simulation", "io", "inspection",
    "identification", "report", "export", "control", "demo", "commands",
)  # fmt: skip
LEVEL = {name: i for i, name in enumerate(ROOMS)}
MOST_FILES = 20  # in one folder
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


def _modules(path: Path, known: set[str]):
    """Modules that a file imports: `from package import module` is the module."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                yield from {full if full in known else node.module} & known


def _room(path: Path) -> str:
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


def _dotted(path: Path) -> str:
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _by_attributes(dotted: str) -> object:
    found: object = seatrial
    for name in dotted.split(".")[1:]:
        found = getattr(found, name)
    return found


def test_every_module_is_in_a_room():
    found = {_room(p) for p in ROOT.rglob("*.py")} - {"__init__"}
    assert found | {"_core"} == set(ROOMS)


def test_no_folder_is_crowded():
    for folder in {p.parent for p in ROOT.rglob("*.py")}:
        assert len(list(folder.glob("*.py"))) <= MOST_FILES, folder


def test_no_public_function_shadows_a_room():
    assert not set(seatrial.__all__) & set(ROOMS)
    for path in ROOT.rglob("*.py"):
        if path != ROOT / "__init__.py":
            importlib.import_module(_dotted(path))
            assert sys.modules[_dotted(path)] is _by_attributes(_dotted(path)), path


def test_imports_go_down_only():
    wrong = []
    for path in ROOT.rglob("*.py"):
        if path == ROOT / "__init__.py":
            continue
        for name in _imports(path):
            parts = name.split(".")
            if parts[0] != "seatrial" or len(parts) == 1:
                continue
            if LEVEL[parts[1]] > LEVEL[_room(path)]:
                wrong.append(f"{path.relative_to(ROOT)} imports {name}")
    assert not wrong, wrong


def test_modules_do_not_import_each_other_in_circles():
    modules = {_dotted(p): p for p in ROOT.rglob("*.py") if p != ROOT / "__init__.py"}
    graph = {name: set(_modules(path, set(modules))) - {name} for name, path in modules.items()}
    assert len(tuple(graphlib.TopologicalSorter(graph).static_order())) == len(modules)


def test_only_edges_import_plotting_or_bag_libraries():
    for path in ROOT.rglob("*.py"):
        if _room(path) not in ("io", "report", "export", "control"):
            assert not EDGES & {n.split(".")[0] for n in _imports(path)}, path


def test_importing_seatrial_is_light():
    code = (
        "import sys, seatrial; print([m for m in ('scipy','plotly','pandas') if m in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"
