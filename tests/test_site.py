# SPDX-License-Identifier: MIT
"""The documentation's site: every page is on it, the reference is the program's, the tutorial runs."""

import re
import sys
from types import SimpleNamespace

import pytest
import yaml
from test_docs import ROOT

from seatrial.commands import COMMANDS
from seatrial.commands.cli import main

sys.path.insert(0, str(ROOT / "tools"))
import flow
import generated
import json_page
import pictures
import reference
import troubleshooting

DOCS = ROOT / "docs"


def pages(nav):
    """Files that a menu names."""
    for entry in nav:
        for target in entry.values():
            yield from pages(target) if isinstance(target, list) else [target]


def test_every_page_is_in_the_menu():
    nav = yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"]
    written = sorted(p.relative_to(DOCS).as_posix() for p in DOCS.rglob("*.md"))
    assert sorted(pages(nav)) == written
    assert any("/" in page for page in written)


def test_the_site_has_whole_pages_where_the_repository_has_short_ones():
    assert "tools/generated.py" in yaml.safe_load((ROOT / "mkdocs.yml").read_text())["hooks"]
    for name, whole in (
        ("reference.md", reference.page()),
        ("json.md", json_page.page()),
        ("troubleshooting.md", troubleshooting.page()),
        ("index.md", "as it is"),
    ):
        page = SimpleNamespace(file=SimpleNamespace(src_uri=name))
        assert generated.on_page_markdown("as it is", page) == whole
        kept = (DOCS / name).read_text()
        assert kept.splitlines()[0] == whole.splitlines()[0] or name == "index.md"


def test_the_reference_is_what_the_program_says():
    assert (DOCS / "reference.md").read_text() == reference.short(), "run tools/reference.py"
    assert "- `identify`: identify a model from recordings" in reference.short()
    text = reference.page()
    for words in (
        "### seatrial identify",
        "`--prior OLD`",
        "### read",
        "class Model",
        "- `velocity`: (3,) u, v [m/s], r [rad/s]",
    ):
        assert words in text


def test_pictures_of_the_tutorial_and_of_the_gallery_are_those_that_the_tool_makes():
    made = {f"tutorial/{name}.png" for name in pictures.PLOTS} | {
        f"{name}.png" for name in pictures.PAGES
    }
    text = "".join((DOCS / page).read_text() for page in ("tutorial.md", "gallery.md"))
    shown = set(re.findall(r"\]\(images/((?:tutorial|gallery)/[^)]+)\)", text))
    kept = {p.relative_to(DOCS / "images").as_posix() for p in (DOCS / "images").rglob("*/*.png")}
    assert made == shown == kept
    for name in pictures.PLOTS:
        assert f'savefig("{name}.png")' in text
    for page in pictures.PAGES.values():
        assert page in text


def test_the_picture_of_the_flow_is_drawn_by_its_tool():
    assert (DOCS / "images" / "flow.svg").read_text() == flow.drawn(), "run tools/flow.py"
    assert "prefers-color-scheme: dark" in flow.drawn()
    named = " ".join(box.head for box in (*flow.STEPS, *flow.USES))
    for word in re.findall(r"[a-z]+", named.replace("on board", "").replace("control", "")):
        assert word == "log" or word in COMMANDS, word


def test_the_page_on_json_is_what_the_program_writes():
    assert (DOCS / "json.md").read_text() == json_page.short(), "run tools/json_page.py"
    assert "`scores 6`, `report 1`" in json_page.short()
    assert "## seatrial validate" in json_page.sections(["validate"])
    assert "| `written` | text | path |" in json_page.page()
    assert "| `rms` | number |" in json_page.page()


@pytest.mark.system
def test_the_tutorial_and_the_gallery_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    shown: dict[str, str] = {}

    def command(arguments):
        code = main(arguments)
        shown[" ".join(arguments[:2])] = capsys.readouterr().out
        return code

    names: dict[str, object] = {}
    pictures.run(DOCS / "tutorial.md", command, names)
    told = capsys.readouterr().out  # of the last block of Python
    assert "/slam/pose" in shown["inspect trials/S1-MP.bag"]
    assert "Proposed by 'seatrial init'" in shown["init trials/S1-MP.bag"]
    assert "assumed: thrusters not known" in shown["auto trials/S1-MP.bag"]
    assert "next: " in shown["auto trials/S1-MP.bag"]
    found = names["model"].values["X_uu"]
    assert abs(found + 1.74) < 0.02
    last = shown["validate model.yaml"]
    assert all(word in last for word in ("ratio", "floor"))
    assert "model (output-error) against other (equation-error), same instants" in last
    assert "better" in last
    assert (tmp_path / "report.html").stat().st_size > 100_000
    error = re.search(r"RMS error (\S+) cm/s from one pose a second", told)
    assert error is not None
    assert float(error[1]) < 0.2
    assert all((tmp_path / f"{name}.png").stat().st_size > 10_000 for name in pictures.PLOTS)
    pictures.run(DOCS / "gallery.md", command, names)
    assert all((tmp_path / page).stat().st_size > 100_000 for page in pictures.PAGES.values())
