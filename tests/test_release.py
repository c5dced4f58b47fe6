# SPDX-License-Identifier: MIT
"""One version everywhere, extras that exist, a recipe that asks for what the package needs."""

import importlib
import pkgutil
import re
import sys

import pytest
import yaml
from conftest import ROOT

import seatrial
from seatrial.util.errors import SeatrialError

sys.path.insert(0, str(ROOT / "tools"))
import release

PROJECT = (ROOT / "pyproject.toml").read_text()


def test_the_version_is_the_same_in_all_places():
    found = release.versions()
    assert len(set(found.values())) == 1, found
    assert "" not in found.values()


def test_the_checklist_names_what_is_missing(monkeypatch):
    monkeypatch.setattr(release, "versions", lambda: {"a": "9.9.9", "b": "9.9.8", "c": ""})
    monkeypatch.setattr(release, "git", lambda *_: "")
    found = {what: holds for what, holds, _ in release.points()}
    assert found["a: version 9.9.9"]
    assert not found["b: version 9.9.8"]
    assert not found["c: version missing"]
    assert not found["CHANGELOG.md: section of 9.9.9"]
    assert found["tag v9.9.9 is free"]


def test_every_extra_that_a_message_names_exists():
    extras = PROJECT.partition("[project.optional-dependencies]")[2].partition("\n[project")[0]
    known = set(re.findall(r"(?m)^(\w+) = \[", extras))
    named = {
        name
        for folder in ("src", "docs")
        for path in (ROOT / folder).rglob("*.[pm][yd]")
        for names in re.findall(r"seatrial\[([\w,]+)\]", path.read_text())
        for name in names.split(",")
    }
    assert {"ardupilot", "mat", "plot", "png", "mpc"} <= named
    assert named <= known


def test_a_missing_pymavlink_is_named_with_its_extra(tmp_path, monkeypatch):
    from seatrial.io.formats import mavlink

    path = tmp_path / "a.tlog"
    path.write_bytes(b"\0" * 100)
    mavlink.messages.cache_clear()
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    with pytest.raises(SeatrialError, match=r"pip install 'seatrial\[ardupilot\]'"):
        seatrial.read(path, seatrial.load_vehicle(ROOT / "data" / "cse1" / "vehicle.yaml"))


def test_a_live_source_without_pymavlink_names_its_extra(monkeypatch):
    from seatrial.io.formats import mavlink
    from seatrial.poolside.sources.mavlink_stream import FrameStream

    mavlink.messages.cache_clear()
    for missing in ("pymavlink.dialects.v20", "fastcrc", "fastcrc.crc16"):
        monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(SeatrialError, match=r"pip install 'seatrial\[ardupilot\]'"):
        FrameStream()


RECIPE = ROOT / "packaging" / "conda" / "recipe.yaml"


def stated(key):
    """The strings of a list in pyproject.toml, as conda writes them."""
    found = re.search(rf"(?ms)^{key} = \[(.*?)\]", PROJECT)
    return {name.lower() for name in re.findall(r'"([^"]+)"', found[1])}


def conda(names):
    return {name.replace(" ", "") for name in names}


def test_the_recipe_needs_what_the_package_needs():
    needs = yaml.safe_load(RECIPE.read_text())["requirements"]
    assert conda(needs["run"]) == stated("dependencies") | {"python>=3.10"}
    assert conda(needs["host"]) == stated("requires") | {"python", "pip"}


def test_the_recipe_names_files_and_a_program_that_exist():
    recipe = yaml.safe_load(RECIPE.read_text())
    source = (RECIPE.parent / recipe["source"]["path"]).resolve()
    assert source == ROOT
    assert (source / recipe["about"]["license_file"]).is_file()
    program, _, place = recipe["build"]["python"]["entry_points"][0].partition(" = ")
    assert f'[project.scripts]\n{program} = "{place}"' in PROJECT
    assert callable(pkgutil.resolve_name(place))
    for test in recipe["tests"]:
        for module in test.get("python", {}).get("imports", ()):
            importlib.import_module(module)
