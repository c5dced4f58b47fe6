# SPDX-License-Identifier: MIT
"""The benchmarks' harness; and every command and file of theirs that a page names is there."""

import json
import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from benchmarks import ablation
from benchmarks.harness import command, store
from benchmarks.harness.markdown import table
from benchmarks.harness.workers import gathered, spread

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    *(ROOT / "docs").rglob("*.md"), *(ROOT / "benchmarks").rglob("*.py"), ROOT / "README.md",
    ROOT / "CONTRIBUTING.md", ROOT / "benchmarks" / "README.md", ROOT / "Makefile",
]  # fmt: skip


def squared(number, scale):
    """One job."""
    return {"value": scale * number**2}


def one_row(seed):
    """A job with random numbers, and arithmetic of NumPy."""
    draws = np.random.default_rng(seed).normal(size=(60, 6))
    return np.linalg.lstsq(draws[:, 1:], draws[:, 0], rcond=None)[0].tolist()


def test_commands_that_pages_name_are_there():
    command = re.compile(r"python -m\s(benchmarks(?:\.[a-z_0-9]+)+)(?![.\w])")
    named = {name for page in PAGES for name in command.findall(page.read_text())}
    assert len(named) > 15
    for name in named:
        spec = find_spec(name)
        assert spec is not None, name
        if spec.submodule_search_locations is not None:
            assert find_spec(f"{name}.__main__") is not None, name


def test_files_of_benchmarks_that_pages_name_are_there():
    for page in PAGES:
        for name in re.findall(r"\b(?:benchmarks|tests/boats)/[\w/]+\.\w+", page.read_text()):
            assert (ROOT / name).exists(), f"{page.name}: {name}"


def test_every_benchmark_is_in_the_readme():
    text = (ROOT / "benchmarks" / "README.md").read_text()
    studies = {p.stem for p in (ROOT / "benchmarks" / "studies").glob("[a-z]*")}
    gates = {p.stem for p in (ROOT / "benchmarks").glob("[a-z]*")} - {"harness", "studies"}
    for name in (studies | gates) - {"scipy_rollout"}:  # a part of estimators
        assert f"`{name}" in text, name


def test_results_are_kept_and_what_is_missing_is_added(tmp_path, capsys):
    path = tmp_path / "results.jsonl"
    jobs = [(n, 10.0) for n in range(3)]
    store.run(path, jobs[:2], squared, "new", workers=1)
    with path.open("a") as file:
        file.write(json.dumps({"value": -1, "job": [2, 10.0], "code": "old"}) + "\n")
        file.write('{"value": 5, "jo')  # the run was stopped here
    store.run(path, jobs, squared, "new", workers=1)
    assert "1 to do, 2 done with this code (new)" in capsys.readouterr().out
    found = store.chosen(store.read(path), "new")
    assert [(r["job"], r["value"]) for r in found] == [([n, 10.0], 10.0 * n**2) for n in range(3)]
    assert len(store.chosen(store.read(path), "new", any_code=True)) == 4


def test_a_digest_is_of_one_benchmarks_code():
    assert store.code("recovery") == store.code("recovery")
    assert store.code("recovery") != store.code("studies/paper")


def test_workers_return_all_jobs_and_gathered_keeps_their_order():
    jobs = [(n, 2.0) for n in (3, 1, 2)]
    assert [r["value"] for r in gathered(squared, jobs, workers=1)] == [18.0, 2.0, 8.0]
    assert dict(spread(squared, jobs, workers=1)) == {job: squared(*job) for job in jobs}


@pytest.mark.system
@pytest.mark.filterwarnings("ignore")  # of Dask's own threads and sockets at the end
def test_results_do_not_depend_on_the_number_of_workers():
    jobs = [(n,) for n in range(4)]
    rows = [gathered(one_row, jobs, workers=count) for count in (1, None)]
    assert rows[0] == rows[1]
    with pytest.raises(ValueError, match="non-negative"):  # what a job raises
        gathered(one_row, [(-1,), (1,)], workers=2)


def test_a_table_has_words_on_the_left_and_figures_on_the_right():
    assert table(["boat", "axis", "m"], [["a", "u", "1"]], text=2).splitlines() == [
        "| boat | axis | m |",
        "| --- | --- | ---: |",
        "| a | u | 1 |",
    ]


@pytest.mark.parametrize(("asked", "made"), [([], ["a", "b"]), (["b"], ["b"])])
def test_tables_are_chosen_by_name(asked, made, capsys):
    makers = {"a": lambda: "A", "b": lambda: "B"}
    command.show(command.tables(command.parser("x", ""), asked, makers), makers, "none.md")
    assert capsys.readouterr().out == "".join(f"## {n}\n\n{n.upper()}\n\n" for n in made)


def test_an_unknown_table_is_an_error_that_lists_those_there_are(capsys):
    with pytest.raises(SystemExit):
        command.tables(command.parser("x", ""), ["c"], ["a", "b"])
    assert "no table c; there are a, b" in capsys.readouterr().err


@pytest.mark.parametrize("branch", ablation.BRANCHES)
def test_what_the_ablation_turns_off_is_there(branch):
    for target in ablation.BRANCHES[branch]:
        module, _, name = target.rpartition(".")
        assert hasattr(import_module(module), name), target
