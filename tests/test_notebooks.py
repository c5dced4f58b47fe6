# SPDX-License-Identifier: MIT
"""Notebooks: stored without outputs, each a page of the documentation, and they run."""

import base64
import json
import re
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
import yaml
from programs import piped
from test_docs import ROOT

sys.path.insert(0, str(ROOT / "tools"))
import notebooks

PATHS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
SHOWN = {  # what each must show, by its last pictures and words
    "first_model": (4, ["95 % interval", "errors off", "S7-MP"]),
    "own_csv": (1, ["unit: mm", "Proposed by", "S7", "ratio"]),
    "odometry": (2, ["odometer, 1 Hz", "within 95 % interval"]),
}
LONGEST_LINE = 130


def names(paths):
    return [path.stem for path in paths]


def test_each_notebook_is_a_page_in_the_menu_with_its_title():
    menu = (ROOT / "mkdocs.yml").read_text()
    assert names(PATHS) == sorted(SHOWN)
    assert names(PATHS) == names(sorted((ROOT / "docs" / "notebooks").glob("*.md")))
    assert "tools/notebooks.py" in yaml.safe_load(menu)["hooks"]
    for path in PATHS:
        first = nbformat.read(path, 4).cells[0].source.splitlines()[0]
        page = (ROOT / "docs" / "notebooks" / f"{path.stem}.md").read_text()
        assert page.splitlines()[0] == first
        assert f"examples/notebooks/{path.name}" in page
        assert f"notebooks/{path.stem}.md" in menu


@pytest.mark.parametrize("path", PATHS, ids=names(PATHS))
def test_it_is_stored_without_outputs(path):
    notebook = nbformat.read(path, 4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        assert max(map(len, cell.source.splitlines())) <= LONGEST_LINE
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None
    assert set(notebook.metadata) == {"kernelspec", "language_info"}


@pytest.mark.parametrize("path", PATHS, ids=names(PATHS))
def test_links_of_its_page_lead_to_pages(path):
    texts = [cell.source for cell in nbformat.read(path, 4).cells if cell.cell_type == "markdown"]
    targets = re.findall(r"\]\(([^)#]+)\)", "\n".join(texts))
    assert targets
    for target in targets:
        assert (ROOT / "docs" / "notebooks" / target).exists(), target


@pytest.mark.system
@pytest.mark.parametrize("path", PATHS, ids=names(PATHS))
def test_it_runs_and_shows_tables_and_pictures(path, tmp_path):
    out = tmp_path / path.name
    command = [sys.executable, str(ROOT / "tools" / "notebooks.py"), str(path), str(out)]
    subprocess.run(command, check=True, cwd=tmp_path)
    notebook = nbformat.read(out, 4)
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert not [o for o in outputs if o.output_type == "error" or o.get("name") == "stderr"]
    pictures = [o.data["image/png"] for o in outputs if "image/png" in o.get("data", {})]
    count, words = SHOWN[path.stem]
    assert len(pictures) == count
    assert all(base64.b64decode(p).startswith(b"\x89PNG") for p in pictures)
    text = json.dumps(outputs, ensure_ascii=False)
    assert [word for word in words if word not in text] == []
    page, files = notebooks.as_markdown(notebook, path.stem)
    assert len(files) == count
    assert all(name in page for name in files)
    assert "<style" not in page
    assert "<Figure" not in page
    assert "object at 0x" not in page
    assert notebooks.kept(path).read_text() == out.read_text()  # for the site


def test_a_notebook_that_fails_is_an_error(tmp_path):
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("assert 1 == 2")])
    nbformat.write(notebook, tmp_path / "wrong.ipynb")
    command = [sys.executable, str(ROOT / "tools" / "notebooks.py"), "wrong.ipynb", "out.ipynb"]
    done = piped(command, cwd=tmp_path)
    assert done.returncode != 0
    assert "assert 1 == 2" in done.stderr
    assert not Path(tmp_path / "out.ipynb").exists()
