# SPDX-License-Identifier: MIT
"""Imports go down only, and the slow ones stay inside the functions that need them."""

import ast
import graphlib
import importlib
import os
import sys
from functools import cache
from pathlib import Path

import pytest
from programs import printed

import seatrial
from seatrial.commands import COMMANDS

ROOT = Path(seatrial.__file__).parent
ROOMS = (  # from the bottom; a room imports only from rooms before it, and from itself
    "_core", "util", "boat", "recording", "evaluation", "onboard", "simulation", "io", "inspection",
    "identification", "monitoring", "workflow", "report", "display", "export", "control", "guide", "fleet", "poolside",
    "demo", "commands", "__main__",
)  # fmt: skip
LEVEL = {name: i for i, name in enumerate(ROOMS)}
MOST_FILES = 20  # in one folder
NAMED_TYPES = ROOT / "util" / "above.py"  # names types for annotations, and loads nothing
EDGES = {
    "plotly", "resvg_py", "rosbags", "lz4", "apsw", "backports", "casadi", "scipy", "matplotlib", "pandas",
    "pymavlink", "fastcrc", "distributed", "starlette", "uvicorn",
}  # fmt: skip


@cache
def _statements(path: Path) -> list[ast.Import | ast.ImportFrom]:
    nodes = ast.walk(ast.parse(path.read_text()))
    return [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]


def _imports(path: Path):
    for node in _statements(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        else:
            assert node.level == 0, f"{path}: relative import"
            if node.module == "seatrial":
                yield from (f"seatrial.{alias.name}" for alias in node.names)
            else:
                yield node.module or ""


def _modules(path: Path, known: set[str]):
    """Modules that a file imports: `from package import module` is the module."""
    for node in _statements(path):
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
    for folder in {p.parent for p in ROOT.rglob("*.py")} - {
        ROOT / "commands"
    }:  # one file a command
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
        if (
            _room(path) not in ("io", "report", "display", "export", "control", "fleet", "poolside")
            and path != NAMED_TYPES
        ):
            assert not EDGES & {n.split(".")[0] for n in _imports(path)}, path


def _loaded(code: str) -> set[str]:
    """Modules of a fresh interpreter after this."""
    ended = f"import sys\ntry:\n    {code}\nexcept SystemExit:\n    pass\nprint(*sys.modules)"
    return set(printed(sys.executable, "-c", ended).splitlines()[-1].split())


@pytest.mark.parametrize("arguments", [["--version"], ["--help"]], ids=" ".join)
def test_the_program_loads_no_command_that_is_not_called(arguments):
    loaded = _loaded(f"from seatrial.commands.cli import main; main({arguments})")
    own = {name for name in loaded if name.startswith("seatrial.")}
    assert own - {"seatrial.commands.shared", "seatrial.commands.shared.examples"} == {
        "seatrial.commands", "seatrial.commands.cli", "seatrial.util", "seatrial.util.errors",
        "seatrial.util.printing", "seatrial.util.progress", "seatrial.util.status",
    }  # fmt: skip
    assert not loaded & {*EDGES, "numpy", "msgspec", "yaml", "rich", "shtab"}


def test_the_program_loads_the_command_that_is_called():
    loaded = _loaded("from seatrial.commands.cli import main; main(['tune', '--help'])")
    called = {name for name in loaded if name.startswith("seatrial.commands.")}
    assert called == {
        f"seatrial.commands.{name}" for name in ("cli", "shared", "tune", "shared.examples")
    }


def test_the_program_runs_blas_with_one_thread_unless_told_otherwise():
    code = "import os; from seatrial.commands.cli import main; main(['export', '--help'])"
    shown = f"import atexit, os; atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS'])); {code}"
    for given, used in ((None, "1"), ("3", "3")):
        own = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
        own |= {} if given is None else {"OPENBLAS_NUM_THREADS": given}
        assert printed(sys.executable, "-c", shown, env=own).splitlines()[-1] == used


def test_every_command_has_its_file():
    files = {p.stem for p in (ROOT / "commands").glob("*.py")} - {"__init__", "cli"}
    assert set(COMMANDS) == files


def test_importing_seatrial_is_light():
    assert {name for name in _loaded("import seatrial") if name.startswith("seatrial.")} == set()
    assert not _loaded("import seatrial; seatrial.identify") & {"scipy", "plotly", "pandas"}


def test_public_names_are_where_type_checkers_find_them():
    tree = ast.parse((ROOT / "__init__.py").read_text())
    block = next(
        n for n in tree.body if isinstance(n, ast.If) and ast.unparse(n.test) == "TYPE_CHECKING"
    )
    typed = {
        alias.asname: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert typed == {name: f"seatrial.{module}" for name, module in seatrial._MODULES.items()}
    assert seatrial.__all__ == sorted(typed)
    for name, module in typed.items():
        assert getattr(seatrial, name) is getattr(importlib.import_module(module), name)
    assert set(dir(seatrial)) >= {*typed, "__doc__", "__file__"}


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'identfy'"):
        _ = seatrial.identfy
    assert not hasattr(seatrial, "__wrapped__")
    assert _loaded("import seatrial; seatrial.export.formats") >= {"seatrial.export.formats"}
