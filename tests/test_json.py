# SPDX-License-Identifier: MIT
"""--json: the result for programs, in a file or on standard output."""

import argparse
import json
import sys
from argparse import Namespace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from autopilot_logs import ardupilot, trial
from cli_tools import documented, done, refused, run
from conftest import CSE1, ROOT
from programs import PROGRAM, printed

from seatrial.commands import COMMANDS, make_parser
from seatrial.commands.shared import write_json
from seatrial.commands.shared.schemas import SCHEMAS, Topic
from seatrial.recording.timing import Stream
from seatrial.util.printing import put

sys.path.insert(0, str(ROOT / "tools"))
import json_page


def test_a_dash_is_standard_output_with_nothing_but_json(pool, tmp_path, capsys):
    command = ("inspect", pool / "S1-AF", "--vehicle", pool / "vehicle-AF.yaml", "--json")
    text = done(capsys, *command, tmp_path / "found.json")
    assert "S1-AF" in text
    out = done(capsys, *command, "-")
    content = json.loads(out)
    assert content["seatrial"] == "inspection 1"
    assert content == json.loads((tmp_path / "found.json").read_text())
    assert not Path("-").exists()
    _, again, _ = run(capsys, *command, tmp_path / "found.json")
    assert again == text  # the text is back after a call with a dash


def test_names_from_a_file_can_not_steer_the_terminal_through_json(capsys):
    write_json(Namespace(json=Path("-")), "test 1", {"name": "a\x1b[2J\x9b2J\u202eb\u2028"})
    out = capsys.readouterr().out
    assert out.isascii()
    assert all(c.isprintable() or c == "\n" for c in out)
    assert json.loads(out) == {"seatrial": "test 1", "name": "a\x1b[2J\x9b2J\u202eb\u2028"}
    with pytest.raises(ValueError, match="ASCII"):
        put("\x9b")


class _Result(msgspec.Struct):
    path: Path
    values: list[float]


def test_paths_numbers_of_numpy_and_what_json_lacks(tmp_path):
    args = Namespace(json=tmp_path / "out.json")
    write_json(args, "test 1", _Result(Path("a/b"), [1.0, float("inf"), float("nan")]))
    assert json.loads(args.json.read_text()) == {
        "seatrial": "test 1",
        "path": "a/b",
        "values": [1.0, None, None],
    }
    write_json(args, "test 1", {"x": np.float64(2.5), "A": np.eye(2), "n": np.int64(3)})
    found = json.loads(args.json.read_text())
    assert found == {"seatrial": "test 1", "x": 2.5, "A": [[1.0, 0.0], [0.0, 1.0]], "n": 3}


def test_content_with_a_kind_of_its_own_keeps_it(tmp_path):
    args = Namespace(json=tmp_path / "out.json")
    write_json(args, "test 1", {"seatrial": "scores 6"})
    assert json.loads(args.json.read_text()) == {"seatrial": "scores 6"}
    write_json(Namespace(json=None), "test 1", {"x": object()})  # not asked for


SIMPLE = {  # arguments, and what else must be in the content
    "inspect": (["{p}/S1-AF", "--vehicle", "{v}"], {"vehicle": "mallard"}),
    "init": (["{p}/S1-AF", "-o", "{o}/v.yaml"], {"vehicle": "{o}/v.yaml"}),
    "convert": (["{p}/S1-AF", "--vehicle", "{v}", "-o", "{o}/S1"], {"recording": "{p}/S1-AF"}),
    "simulate": (["--plan", "{o}/plan.yaml", "-o", "{o}/trials"], {"folder": "{o}/trials"}),
    "validate": (["{m}", "{p}/S7-AF", "--end", "100"], {"horizon": 1.0}),
    "identify": (
        ["{p}/S1-AF", "{p}/S2-AF", "{p}/S3-AF", "--vehicle", "{v}", "-o", "{o}/m.yaml", "--method", "equation-error"],
        {"model": "{o}/m.yaml", "method": "equation-error"},
    ),
    "report": (["{m}", "{p}/S7-AF", "--end", "60", "-o", "{o}/r.html"], {"written": ["{o}/r.html"]}),
    "compare": (["{m}", "{m}"], {}),
    "tune": (["{m}"], {"action": "pid"}),
    "predict": (["{m}", "{p}/S7-AF", "--end", "20", "-o", "{o}/out.csv"], {"recording": "S7-AF"}),
    "allocate": (["{m}"], {"axes": "forward-left-up"}),
    "export": (["{m}", "--to", "c", "-o", "{o}/boat.h"], {"format": "c", "written": "{o}/boat.h"}),
    "completion": (["bash"], {"shell": "bash"}),
}  # fmt: skip


@pytest.mark.parametrize("command", SIMPLE)
def test_each_command_writes_what_is_documented(command, pool, tmp_path, capsys):
    (tmp_path / "plan.yaml").write_text(
        "seatrial: plan 1\nbased_on: clean\ntrials: {S1: {drive: surge, duration: 12}}\n"
    )
    arguments, expected = SIMPLE[command]
    places = {"p": pool, "v": pool / "vehicle-AF.yaml", "m": pool / "model.yaml", "o": tmp_path}
    given = [word.format(**places) for word in arguments]
    out = tmp_path / "found.json"
    assert run(capsys, command, *given, "--json", out)[0] == 0
    content = documented(command, out)
    for name, value in expected.items():
        assert content[name] == _filled(value, places), name
    for written in _paths(content):
        assert Path(written).exists()


def _filled(value, places):
    if isinstance(value, list):
        return [_filled(one, places) for one in value]
    return value.format(**places) if isinstance(value, str) else value


def _paths(content) -> list[str]:
    """Files that a result names."""
    written = content.get("written", [])
    trials = [path for one in content.get("vehicles", []) for path in one["trials"]]
    return [*([written] if isinstance(written, str) else written), *trials]


@pytest.mark.parametrize(
    "arguments", [["sim", "--speed", "0", "--duration", "1"], ["mimic", "--speed", "1"]], ids=["sim", "mimic"]
)  # fmt: skip
def test_a_command_of_lines_writes_its_result_at_the_end(arguments, pool, tmp_path):
    command, *options = arguments
    out = tmp_path / "found.json"
    printed(PROGRAM, command, pool / "model.yaml", *options, "--json", out, input="nonsense\n")
    content = documented(command, out)
    assert (content["lines"], content["mistakes"]) == (1, 1)


def test_contents_without_a_vehicle_file_are_documented(pool, tmp_path, capsys):
    out = tmp_path / "found.json"
    assert run(capsys, "inspect", pool / "S1-AF", "--json", out)[0] == 0
    assert documented("inspect", out)["recordings"][0]["kind"] == "tables"
    bag = CSE1 / "mcap" / "CSE1_data_run1.mcap"
    assert run(capsys, "inspect", bag, "--json", out)[0] == 0
    assert len(documented("inspect", out)["recordings"][0]["topics"]) > 1
    log = ardupilot(tmp_path / "log.BIN", trial(seconds=20.0))
    assert run(capsys, "inspect", log, "--json", out)[0] == 0
    topics = documented("inspect", out)["recordings"][0]["topics"]
    assert any(topic["fields"] for topic in topics)


def test_every_command_takes_json_and_has_a_documented_kind():
    parser = make_parser()
    (commands,) = (a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    for name, command in commands.choices.items():
        command.fill()
        assert "--json" in command._option_string_actions, name
    assert set(SCHEMAS) == set(COMMANDS)


@pytest.mark.parametrize("command", ["sim", "mimic"])
def test_lines_and_json_do_not_share_standard_output(command, pool, capsys):
    err = refused(capsys, command, pool / "model.yaml", "--json", "-")
    assert "the lines are on standard output; give a file, or --udp PORT" in err


def test_a_result_is_not_written_over_an_input(pool, tmp_path, capsys):
    model = tmp_path / "model.yaml"
    model.write_text((pool / "model.yaml").read_text())
    for command in (["tune", model], ["export", model, "--to", "c", "-o", tmp_path / "boat.h"]):
        assert "give another name" in refused(capsys, *command, "--json", model)


def test_a_topic_has_every_field_of_the_stream_that_it_is_made_of():
    """It is a class of its own as its role may be null; names, types and comments are those of the stream."""
    topic = {name: (kind, comment) for name, kind, comment in json_page.fields(Topic)}
    for name, kind, comment in json_page.fields(Stream):
        if name in ("role", "source", "kind"):
            assert name in topic
            continue
        assert topic[name][0] == kind, name
        assert comment in ("", topic[name][1]) or name == "cut", name
