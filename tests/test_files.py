# SPDX-License-Identifier: MIT
"""Files: strict in, whole or nothing out."""

import os
import stat

import msgspec
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import seatrial
from seatrial import load_vehicle
from seatrial.boat.schema import VehicleFile
from seatrial.boat.vehicle import vehicle_from
from seatrial.simulation.plan import load_plan
from seatrial.util.errors import FileError, SeatrialError
from seatrial.util.files import convert, dump_yaml, read_yaml, write_chunks, write_text


def test_numbers_are_numbers_and_words_are_words(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("a: 1e-3\nb: on\nc: 2.\nd: true\ne: .5\nf: 12\ng: 2014-01-01\n")
    assert read_yaml(path) == {
        "a": 1e-3, "b": "on", "c": 2.0, "d": True, "e": 0.5, "f": 12, "g": "2014-01-01",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: 1\na: 2\n", "key 'a' stands twice"),
        ("a: [1\n", "line 2 is not YAML"),
        ("- 1\n", "expected 'key: value'"),
        ("", "expected 'key: value'"),
        ("{a: 1}: 2\n", "a key must be a word"),
        ("\x00", "is not YAML"),
    ],
)
def test_what_is_not_a_mapping_is_refused_with_its_line(tmp_path, text, words):
    path = tmp_path / "a.yaml"
    path.write_text(text)
    with pytest.raises(FileError, match=words):
        read_yaml(path)


def test_a_tab_is_called_a_tab(tmp_path):
    (tmp_path / "a.yaml").write_text("a:\n\tb: 1\n")
    with pytest.raises(FileError, match="tab"):
        read_yaml(tmp_path / "a.yaml")


@pytest.mark.parametrize(
    ("loader", "kind"),
    [(load_vehicle, "vehicle 1"), (load_plan, "plan 1"), (seatrial.load, "model 3")],
)
def test_one_kind_of_file_given_for_another_says_what_it_is(tmp_path, loader, kind):
    (tmp_path / "a.yaml").write_text("seatrial: cake 1\n")
    with pytest.raises(FileError, match=f"says 'seatrial: cake 1'; expected 'seatrial: {kind}'"):
        loader(tmp_path / "a.yaml")
    (tmp_path / "a.yaml").write_text("name: x\n")
    with pytest.raises(FileError, match=r"has no line 'seatrial: \.\.\.'"):
        loader(tmp_path / "a.yaml")


def test_links_are_followed_and_pipes_are_written_to(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "real.txt")
    write_text(tmp_path / "link", "x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real.txt").read_text() == "x"
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_text(tmp_path / "pipe", "through")
    assert os.read(reader, 100) == b"through"
    os.close(reader)
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    with pytest.raises(FileError, match="is a folder"):
        write_text(tmp_path, "x")


def test_a_missing_file_is_one_line(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_yaml(tmp_path / "none.yaml")


def vehicle_content():
    return load_vehicle("mallard-mp").to_mapping()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.update(axis="up"), "unknown key 'axis'; did you mean 'axes'"),
        (lambda c: c.update(axes="up"), "axes: got 'up'; expected forward-left-up, forward-right-down"),
        (lambda c: c.update(chain={"lag": 0.1}), "chain: expected a list, got a mapping"),
        (lambda c: c["commands"]["inputs"].update({1.5: "x"}), "commands.inputs"),
        (
            lambda c: c["thrusters"]["F_1"].update(angle_deg=float("nan")),
            "thrusters.F_1.angle_deg: nan is not a finite",
        ),
        (lambda c: c.update(chain=[{"lag": float("inf")}]), r"chain\[0\].lag: inf is not a finite"),
        (lambda c: c.update(chain=[{"latency": 1e9}]), "chain"),
        (lambda c: c["pose"].update(yaw="psi"), "unknown key 'yaw' in pose"),
        (lambda c: c["commands"].pop("inputs"), "key 'inputs' is missing in commands"),
        (lambda c: c["pose"].update(x={"column": "x", "unit": "furlong"}), "pose.x"),
        (lambda c: c["thrusters"]["F_1"].update(x="left"), "thrusters"),
        (lambda c: c.update(chain=[{"lag": -1.0}]), "chain"),
        (lambda c: c.update(chain=[{"dead_zone": {"forward": 1.2, "reverse": 0}}]), "dead_zone"),
        (lambda c: c.update(seatrial="vehicle 2"), "seatrial"),
        (lambda c: c.update(name=3), "name: expected text"),
    ],
)  # fmt: skip
def test_a_wrong_vehicle_file_names_the_place(change, words):
    content = vehicle_content()
    change(content)
    with pytest.raises(FileError, match=words):
        convert(content, VehicleFile, "v.yaml")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.update(thrusters={}), "needs thrusters"),
        (lambda c: c["thrusters"]["F_3"].update(y=1e308), r"thrusters\.F_3\.y: expected a number <= 1000\.0"),
        (lambda c: c["pose"].update(lever=[0.0, -1e308]), r"pose\.lever\[1\]: expected a number >= -1000\.0"),
        (lambda c: c.update(thrusters={}, allocation={"scheme": "direct"}, commands={"stamp": "t", "inputs": {"a": "a"}}),
         "they must be F_u, F_v, F_r"),
        (lambda c: c.update(allocation={"scheme": "direct"}), "inputs must be the thrusters F_1"),
        (lambda c: c.update(allocation={"scheme": "always-forward", "F_os": 1.0, "limit": 0.5}), "leaves no room"),
        (lambda c: c.update(chain=[{"actuators": ["F_9"], "lag": 0.1}]), "names 'F_9'"),
        (lambda c: c.update(chain=[{"lag": 0.1}, {"name": "b", "lag": 0.2}]), "two groups give lag of"),
        (lambda c: c.update(chain=[{"scale": {"signal": "rpm"}}]), "scale 'rpm'"),
        (lambda c: c.update(chain=[{"gains": {"F_1": 2.0, "F_2": 1.0}}]), "it must be 1"),
        (lambda c: c.update(chain=[{"table": [[0, 0], [1, 0.5]]}]), "thrust 1 at command 1"),
        (lambda c: c.update(chain=[{"actuators": ["F_1"], "table": [[0, 0], [1, 1]]},
                                   {"name": "b", "actuators": ["F_2"], "table": [[0, 0], [1, 1]]}]), "one table at most"),
        (lambda c: c.update(structure={"sway": ["Y_v * v - 2 * v"]}), "is a sum; write one term a line"),
        (lambda c: c.update(forces={"F_u": {"axis": "surge", "of": {"F_1": 1}}}), "not both"),
        (lambda c: c.update(chain=[{"table": [[1, 1], [0, 0]]}]), "rising commands"),
        (lambda c: c.update(structure={"surge": ["X_u * q"]}), "factor 'q'"),
        (lambda c: c.update(structure="malard"), "no structure named 'malard'"),
    ],
)  # fmt: skip
def test_a_vehicle_that_contradicts_itself_is_refused(change, words):
    content = vehicle_content()
    change(content)
    with pytest.raises(SeatrialError, match=words):
        vehicle_from(content, "v.yaml")


def test_a_plan_with_a_wrong_key_says_where(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("seatrial: plan 1\nbased_on: paper-like\npose: {position_nois: 0.1}\n")
    with pytest.raises(
        FileError, match="unknown key 'position_nois' in pose; did you mean 'position_noise'"
    ):
        load_plan(path)
    path.write_text("seatrial: plan 1\nbased_on: nowhere\n")
    with pytest.raises(FileError, match="'nowhere'; there are clean, hard, lake, paper-like"):
        load_plan(path)


def test_a_plan_is_based_on_a_bundled_one_by_name_never_on_a_path(tmp_path, monkeypatch):
    """A file of that path, or of a bundled plan's name, is not read."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "p.yaml"
    for name in ("other.yaml", "hard"):
        (tmp_path / name).write_text("seatrial: plan 1\nsecret: 1\n")
    for base in (
        "other.yaml",
        f"{tmp_path}/other.yaml",
        "./hard",
        "../plans/hard",
        "hard.yaml",
        str(path),
        "",
        "[hard]",
    ):
        path.write_text(f"seatrial: plan 1\nbased_on: {base or repr('')}\n")
        with pytest.raises(
            FileError,
            match=r"based_on: no bundled plan is named '.*'; there are clean, hard, lake, paper-like",
        ):
            load_plan(path)
    path.write_text("seatrial: plan 1\nbased_on: hard\nname: hard\n")
    found = load_plan(path)
    monkeypatch.chdir("/")
    assert found == load_plan("hard")


def test_presets_differ_only_in_what_they_say():
    paper, hard, clean = (load_plan(n) for n in ("paper-like", "hard", "clean"))
    assert (paper.pose.position_noise, paper.pose.heading_noise) == (0.0007, 0.003)
    assert (hard.pose.position_noise, hard.pose.heading_noise) == (0.004, 0.004)
    assert (clean.pose.position_noise, clean.joypad.clock_offset) == (0.0, 0.0)
    back = msgspec.structs.replace(hard, name="paper-like", pose=paper.pose)
    assert back == paper


def test_writing_leaves_the_old_file_where_the_new_can_not_be_written(tmp_path):
    path = tmp_path / "out.txt"
    path.write_text("old")
    with pytest.raises(UnicodeEncodeError):
        write_text(path, "new \ud800")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["out.txt"]


def test_written_files_have_the_users_usual_permissions(tmp_path):
    old = os.umask(0o022)
    try:
        write_text(tmp_path / "deep" / "out.txt", "x")
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "deep" / "out.txt").stat().st_mode) == 0o644


def test_no_other_thread_makes_files_that_anybody_may_write(tmp_path, monkeypatch):
    """The mask of permissions is the process's: set for a moment, it is that of all threads."""

    def forbidden(_):
        raise AssertionError("the process's mask was set")

    monkeypatch.setattr(os, "umask", forbidden)
    write_text(tmp_path / "out.txt", "x")
    assert (tmp_path / "out.txt").read_text() == "x"


def test_what_is_made_while_it_is_written_is_whole_or_not_there(tmp_path):
    def chunks(fault):
        yield b"one\n"
        if fault is not None:
            raise fault
        yield b"two\n"

    path = tmp_path / "out.txt"
    write_chunks(path, chunks(None))
    assert path.read_bytes() == b"one\ntwo\n"
    for fault, seen in (
        (OSError(28, "No space left on device"), FileError),
        (KeyError(), KeyError),
    ):
        with pytest.raises(seen):
            write_chunks(path, chunks(fault))
        assert path.read_bytes() == b"one\ntwo\n"
        assert [p.name for p in tmp_path.iterdir()] == ["out.txt"]


def test_a_folder_that_is_a_file_is_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="can't be written"):
        write_text(tmp_path / "file" / "out.txt", "x")


NUMBERS = st.floats(allow_nan=False, allow_infinity=False, width=32)


@given(
    st.dictionaries(
        st.text("abcdefgh_", min_size=1, max_size=8),
        st.one_of(
            NUMBERS,
            st.integers(),
            st.text(st.characters(categories=["L", "N", "P", "S", "Zs"]), max_size=30),
            st.booleans(),
            st.lists(NUMBERS, max_size=5),
        ),
        max_size=8,
    )
)
@example({"a": "1e3"})
def test_what_is_dumped_is_read_back(content):
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.yaml"
        path.write_text(dump_yaml({"first": 0, **content}), encoding="utf-8")
        got = read_yaml(path)
    for key, value in content.items():
        assert (
            got[key] == pytest.approx(value, rel=1e-9)
            if not isinstance(value, (str, bool))
            else got[key] == value
        )
