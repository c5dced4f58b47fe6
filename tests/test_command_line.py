# SPDX-License-Identifier: MIT
"""Manners of the command line: examples, what was meant, completion by the shell."""

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from programs import PROGRAM, piped, printed

from seatrial.commands import COMMANDS, make_parser
from seatrial.commands.cli import main
from seatrial.commands.completion import SHELLS, script
from seatrial.commands.shared.examples import EXAMPLES

EVERY_EXAMPLE = [(name, line) for name, text in EXAMPLES.items() for line in text.splitlines()]


def refused(capsys, *arguments: str) -> str:
    """The line about wrong arguments."""
    with pytest.raises(SystemExit) as left:
        main(arguments)
    assert left.value.code == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    return shown.err.strip()


def test_every_command_has_two_or_three_examples():
    assert set(EXAMPLES) == {"", *COMMANDS}
    assert {len(text.splitlines()) for text in EXAMPLES.values()} <= {2, 3}


@pytest.mark.parametrize(("name", "line"), EVERY_EXAMPLE, ids=[line for _, line in EVERY_EXAMPLE])
def test_an_example_is_taken_by_the_parser_of_its_command(name, line):
    words = shlex.split(line, comments=True)
    ends = [words.index(end) for end in ("|", ">", "<") if end in words]
    program, command, *rest = words[: min(ends, default=None)]
    assert program == "seatrial"
    assert name in ("", command)
    args = make_parser().parse_args([command, *rest])
    assert args.run.__module__ == f"seatrial.commands.{command}"


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_ends_with_the_examples_line_by_line(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    with pytest.raises(SystemExit) as left:
        main([*command.split(), "--help"])
    assert left.value.code == 0
    shown = capsys.readouterr().out
    assert "\x1b" not in shown
    examples = "".join(f"\n  {line}" for line in EXAMPLES[command].splitlines())
    assert shown.endswith(f"\nexamples:{examples}\n")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["indentify"], "seatrial: unknown command 'indentify'; did you mean identify? See seatrial --help"),
        (["--verison"], "seatrial: unknown option --verison; did you mean --version? See seatrial --help"),
        (
            ["identify", "x", "--vehcle", "v", "-o", "m"],  # --vehicle would be missing, too
            "seatrial identify: unknown option --vehcle; did you mean --vehicle? See seatrial identify --help",
        ),
        (
            ["validate", "m", "x", "--horizn=2"],
            "seatrial validate: unknown option --horizn; did you mean --horizon? See seatrial validate --help",
        ),
        (
            ["identify", "x", "--vehicle", "v", "-o", "m", "--method", "output-eror"],
            "seatrial identify: unknown value for --method 'output-eror'; did you mean output-error? "
            "See seatrial identify --help",
        ),
        (["tune", "m", "--action", "x"], "seatrial tune: unknown value for --action 'x'; known: pid, pd; see seatrial tune --help"),
        (["tune", "m", "--zzzzz"], "seatrial tune: unknown option --zzzzz; see seatrial tune --help"),
    ],
)  # fmt: skip
def test_a_misspelt_word_gets_the_one_that_was_meant(arguments, line, capsys):
    assert refused(capsys, *arguments) == line


def test_an_unknown_command_unlike_any_other_gets_them_all(capsys):
    line = refused(capsys, "zzz")
    assert line.startswith("seatrial: unknown command 'zzz'; known: auto, demo, inspect, ")


def test_wrong_words_can_not_steer_the_terminal(capsys):
    assert "\x1b" not in refused(capsys, "ident\x1b[2Jify")
    assert "\x1b" not in refused(capsys, "tune", "m", "--kn\x1b[2Job")


def test_options_may_still_be_shortened_and_words_may_begin_with_dashes():
    args = make_parser().parse_args(["tune", "m", "--kno", "2", "--", "--model"][:4])
    assert args.knob == 2.0
    parsed = make_parser().parse_args(["tune", "--", "--model"])
    assert parsed.model == Path("--model")
    chosen = ["select", "r", "--vehicle", "v", "--candidates", "-1.0 * r", "-- r"]
    assert make_parser().parse_args(chosen).candidates == ["-1.0 * r", "-- r"]


def completed(words: str) -> set[str]:
    """What bash offers for the last of these words."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash")
    ask = f"""
source <("$0" completion bash)
COMP_LINE={shlex.quote(words)}
COMP_POINT=${{#COMP_LINE}}
COMP_WORDS=({words}{" ''" if words.endswith(" ") else ""})
COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
$(complete -p seatrial | sed 's/.*-F \\([^ ]*\\).*/\\1/')
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    shown = piped([bash, "--norc", "-c", ask, PROGRAM], check=True)
    assert shown.stderr == ""
    return set(shown.stdout.split())


def test_bash_completes_commands_options_choices_and_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.yaml").touch()
    assert completed("seatrial ide") == {"identify"}
    assert completed("seatrial ") >= set(COMMANDS)
    assert completed("seatrial identify --pri") == {"--prior", "--prior-spread"}
    assert completed("seatrial identify --method e") == {"equation-error"}
    assert "model.yaml" in completed("seatrial validate mod")
    assert "model.yaml" in completed("seatrial identify --prior mod")


@pytest.mark.parametrize("shell", SHELLS)
def test_each_shell_gets_all_commands(shell):
    text = script(shell)
    assert all(re.search(rf"\b{name}\b", text) for name in COMMANDS)
    assert "bootstrap" in text
    if shutil.which(shell) and shell != "tcsh":  # its check needs a terminal
        assert subprocess.run([shell, "-n"], input=text, text=True, check=False).returncode == 0


def test_the_version_is_shown_at_once():
    resource = pytest.importorskip("resource")  # not on Windows
    times = []
    for _ in range(5):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        printed(PROGRAM, "--version")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    assert min(times) < 0.2  # [s] of CPU: what else runs does not count
