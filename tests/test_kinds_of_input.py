# SPDX-License-Identifier: MIT
"""What is no recording is refused in words: a folder of recordings, a note, a file of another kind."""

import shutil

import pytest
from cli_tools import refused
from conftest import CSE1

from seatrial.io.kinds import recordings_in

RUN = CSE1 / "csv" / "CSE1_data_run1.csv"


@pytest.fixture
def folder(tmp_path):
    """A folder with two recordings one level down, and things that are none."""
    whole = tmp_path / "trials"
    for name in ("first run", "second"):
        (whole / name).mkdir(parents=True)
        shutil.copy(RUN, whole / name / "log.csv")
    (whole / "notes").mkdir()
    (whole / "notes" / "sketch.png").write_bytes(b"")
    for name in (".hidden", "truth"):  # the truth: of simulated trials
        (whole / name).mkdir()
        shutil.copy(RUN, whole / name / "log.csv")
    return whole


@pytest.mark.parametrize(
    "command", [["inspect"], ["init", "-o", "v.yaml"], ["auto", "-o", "out", "--yes"]]
)
def test_a_folder_of_recordings_is_named_with_what_is_in_it(
    command, folder, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    said = refused(capsys, *command, "trials")
    assert (
        "trials: is no recording but a folder with 2 recordings: give trials/first run and trials/second"
        in said
    )
    assert [path.name for path in recordings_in(folder)] == ["first run", "second"]


def test_a_note_is_not_taken_for_a_log(tmp_path, capsys):
    note = tmp_path / "boat.txt"
    note.write_text(
        "My boat: a catamaran with two thrusters, 1.4 m\nsteering: one thruster, stern, each\n"
    )
    assert "Is it a note? A .txt file is read as a table" in refused(capsys, "inspect", note)


@pytest.mark.parametrize("name", ["photo.jpg", "vehicle.yaml"])
def test_a_file_of_another_kind_is_refused_by_its_name(name, tmp_path, capsys):
    (tmp_path / name).write_text("a: 1\n")
    said = refused(capsys, "init", tmp_path / name, "-o", tmp_path / "v.yaml")
    assert "expected a bag (.bag, .mcap" in said and f"got '.{name.rpartition('.')[2]}'" in said
    assert ("a vehicle file is given as --vehicle" in said) == name.endswith(".yaml")
