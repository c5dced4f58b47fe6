# SPDX-License-Identifier: MIT
"""The documentation's site: every page is on it, the reference is the program's, the tutorial runs."""

import contextlib
import re
import shlex
import sys

import pytest
import yaml
from test_docs import ROOT, blocks

from seatrial.commands.cli import main

sys.path.insert(0, str(ROOT / "tools"))
import json_page
import reference

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


def test_the_reference_is_what_the_program_says():
    assert (DOCS / "reference.md").read_text() == reference.page(), "run tools/reference.py"
    text = reference.page()
    for words in ("### seatrial identify", "`--prior OLD`", "### read", "class Model"):
        assert words in text


def test_the_page_on_json_is_what_the_program_writes():
    assert (DOCS / "json.md").read_text() == json_page.page(), "run tools/json_page.py"
    assert "| `written` | text | path |" in json_page.page()
    assert "| `rms` | number |" in json_page.page()


@pytest.mark.system
def test_the_tutorial_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shown = []
    for block in blocks(DOCS / "tutorial.md", "sh"):
        for line in block.splitlines():
            program, *arguments = shlex.split(line)
            assert program == "seatrial"
            assert main([*arguments, "--quiet"]) == 0, line
            shown.append(capsys.readouterr().out)
    assert "/slam/pose" in shown[1]
    assert "X_uu" in shown[3]
    found = re.search(r"X_uu +(\S+) ±", shown[3])
    assert found is not None
    assert abs(float(found[1]) + 1.74) < 0.02
    assert all(word in shown[4] for word in ("ratio", "floor"))
    assert "model (output-error) against other (equation-error), same instants" in shown[-1]
    assert "better" in shown[-1]
    assert (tmp_path / "report.html").stat().st_size > 100_000
    with contextlib.redirect_stdout(None):
        exec(compile(blocks(DOCS / "tutorial.md", "python")[0], "tutorial", "exec"), {})
