# SPDX-License-Identifier: MIT
"""Ctrl-C and power cuts: what was begun can be begun again, and no file is half there."""

import os
import sys
from pathlib import Path

import pytest
from programs import piped, printed

import seatrial
from seatrial.commands.cli import INTERRUPTED, main
from seatrial.io import trial_files
from seatrial.simulation.plan import load_plan
from seatrial.util import files
from seatrial.util.files import dump_yaml, write_text

STEPS = ["write_text", "save", "_write_table", "write_bag"]


@pytest.fixture
def plan(tmp_path):
    """Two short trials."""
    import msgspec

    whole = load_plan("clean")
    trials = {name: whole.trials[name] for name in list(whole.trials)[:2]}
    short = msgspec.structs.replace(whole, vehicles=["mallard-mp"], trials=trials)
    (tmp_path / "plan.yaml").write_text(
        dump_yaml({"seatrial": "plan 1", **msgspec.to_builtins(short)})
    )
    return tmp_path / "plan.yaml"


@pytest.mark.system
@pytest.mark.parametrize("kind", ["csv", "mcap"])
def test_simulate_goes_on_in_its_folder_after_any_interrupt(tmp_path, plan, monkeypatch, kind):
    """Interrupted at its 1st, 2nd ... write, then run again."""
    out, arguments = (
        tmp_path / "out",
        ["simulate", "--plan", str(plan), "--format", kind, "-q", "-o"],
    )
    real = {name: getattr(trial_files, name) for name in STEPS}
    for after in range(1, 20):
        left = [after]

        def counted(name, left=left):
            def one(*arguments):
                left[0] -= 1
                if left[0] == 0:
                    raise KeyboardInterrupt
                return real[name](*arguments)

            return one

        with monkeypatch.context() as patched:
            for name in STEPS:
                patched.setattr(trial_files, name, counted(name))
            code = main([*arguments, str(out)])
        if left[0] > 0:
            assert code == 0
            break
        assert code == INTERRUPTED
    assert after > 6
    assert main([*arguments, str(tmp_path / "once")]) == 0
    assert tree(out) == tree(tmp_path / "once")


def tree(folder) -> dict[str, bytes]:
    paths = sorted(
        p
        for p in folder.rglob("*")
        if p.is_file() and p.suffix != ".mcap" and p.name != "written.json"
    )
    return {str(p.relative_to(folder)): p.read_bytes() for p in paths}


def test_a_file_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    done: list[str] = []
    sync, replace = os.fsync, type(tmp_path).replace
    monkeypatch.setattr(os, "fsync", lambda handle: done.append("sync") or sync(handle))
    monkeypatch.setattr(
        type(tmp_path), "replace", lambda self, to: done.append("rename") or replace(self, to)
    )
    write_text(tmp_path / "a.txt", "words")
    assert done == ["sync", "rename", "sync"]  # of the file; of the folder
    assert (tmp_path / "a.txt").read_text() == "words"


def test_a_file_that_can_not_be_synced_leaves_the_old_one(tmp_path, monkeypatch):
    (tmp_path / "a.txt").write_text("old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(seatrial.SeatrialError, match="can't be written"):
        write_text(tmp_path / "a.txt", "new")
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("a.txt", "old")]


def test_a_file_with_the_longest_name_is_written(tmp_path):
    for name in (
        "x" * 251 + ".txt",
        "\N{CJK UNIFIED IDEOGRAPH-8239}" * 83 + ".txt",
    ):  # 255, 253 bytes
        write_text(tmp_path / name, "words")
        assert (tmp_path / name).read_text() == "words"


INTERRUPTED_AT = """
import sys
class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupt())
sys.argv[1:] = ["inspect", "poses.csv"]
from seatrial.__main__ import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    "module",
    ["seatrial.commands.cli", "argparse", "threading", "seatrial.commands.inspect", "numpy"],
)
def test_ctrl_c_while_a_module_is_imported_prints_no_traceback(module):
    code = INTERRUPTED_AT.format(module=module)
    done = piped([sys.executable, "-c", code])
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, "", "")


def test_the_program_begins_where_ctrl_c_is_guarded():
    project = (Path(__file__).parents[1] / "pyproject.toml").read_text()
    assert '[project.scripts]\nseatrial = "seatrial.__main__:main"\n' in project
    assert printed(sys.executable, "-m", "seatrial", "--version").startswith("seatrial ")
