# SPDX-License-Identifier: MIT
"""Text on a terminal: colours where it has them, lines that fit, nothing that data inject."""

import io
import os
import re
import subprocess

import pytest
from conftest import at_length
from programs import PROGRAM, printed
from rich.cells import cell_len

from seatrial.util import printing
from seatrial.util.console import terminal
from seatrial.util.console.progress_line import ProgressLine
from seatrial.util.errors import printable
from seatrial.util.format import table
from seatrial.util.printing import coloured, columns_of, say, tables_fit

ESCAPE = re.compile(r"\x1b\[[\d;]*m")
TABLE = """\
RMS error
  recording   error  unit   constant  ratio   floor
  S4-AF  u    0.001  cm/s      4.814   0.00   0.000
         v    0.002  cm/s      1.123   0.01   0.000
         r    0.003  rad/s     0.075   0.02   0.000"""


class Tty(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def _environment(monkeypatch):
    for name in ("NO_COLOR", "FORCE_COLOR", "COLUMNS", "COLORTERM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")


def plain(text: str, columns: int) -> list[str]:
    return terminal.drawn(text, Tty(), colour=False, columns=columns).split("\n")


def in_colour(text: str) -> str:
    return terminal.drawn(text, Tty(), colour=True, columns=80)


def test_lines_that_fit_are_unchanged():
    text = f"{TABLE}\n\n  => good for identification\n"
    assert plain("\tword", 80) == ["        word"]
    assert "\n".join(plain(text, 80)) == text
    assert ESCAPE.sub("", in_colour(text)) == text


def test_a_long_line_is_broken_between_words_and_indented():
    assert plain("  note: one two three four five six", 20) == [
        "  note: one two", "      three four", "      five six",
    ]  # fmt: skip
    assert plain("# one two three four", 12) == ["# one two", "# three four"]
    assert plain("x" * 30, 20) == ["x" * 30]  # no place to break
    assert all(cell_len(line) <= 20 for line in plain("次の 船の モデル は とても よい です", 20))


@pytest.mark.parametrize("before", ["wrote a.yaml; next: ", "  ", "  => "])
def test_a_command_to_copy_stays_on_one_line(before):
    line = f"{before}seatrial identify {'x ' * 40}y"
    assert plain(line, 40) == [line]


def test_a_wide_table_continues_below_with_its_first_column():
    assert plain(TABLE, 40) == [
        "RMS error", "  recording   error  unit   constant", "  S4-AF  u    0.001  cm/s      4.814",
        "         v    0.002  cm/s      1.123", "         r    0.003  rad/s     0.075",
        "  recording  ratio   floor", "  S4-AF  u    0.00   0.000", "         v    0.01   0.000",
        "         r    0.02   0.000",
    ]  # fmt: skip


@pytest.mark.parametrize("columns", range(30, 60, 7))
def test_no_cell_is_lost_and_no_line_is_too_wide(columns):
    lines = plain(TABLE, columns)
    assert all(len(line) <= columns for line in lines)
    for cell in re.findall(r"\S+", TABLE):
        assert any(cell in line for line in lines)


def test_a_sentence_stays_with_its_row():
    rows = "\n".join(
        f"  X_{i} * u   {i}.25   {i} %   out: too small to be told apart" for i in range(3)
    )
    assert plain(rows, 40)[:2] == [
        "  X_0 * u   0.25   0 %",
        "      out: too small to be told apart",
    ]


def test_a_narrow_terminal_does_not_get_the_spare_columns():
    head, rows = ("term", "value", "spread", "z"), [("X_u * u", "-0.25", "0.5", "-74")]
    whole = table(head, rows, spare=(2, 3))
    assert whole == "  term     value  spread    z\n  X_u * u  -0.25     0.5  -74"
    for columns, expected in (
        (29, whole),
        (28, "  term     value    z\n  X_u * u  -0.25  -74"),
        (10, "  term     value\n  X_u * u  -0.25"),
    ):
        with tables_fit(columns):
            assert table(head, rows, spare=(2, 3)) == expected
            assert table(head, rows) == whole
    assert table(head, rows, spare=(2, 3)) == whole


def test_headings_findings_and_steps_have_colours():
    shown = in_colour("Trial 1: 20 s\n  => swap x and y\nwrote a; next: seatrial report a\n")
    assert shown == (
        "\x1b[1mTrial 1:\x1b[0m 20 s\n\x1b[33m  => swap x and y\x1b[0m\n"
        "\x1b[1;32mwrote\x1b[0m a; \x1b[1;36mnext:\x1b[0m \x1b[36mseatrial report a\x1b[0m\n"
    )


def test_data_can_not_inject_markup_or_escape_sequences():
    hostile = "[bold red]a[/] [link=http://x]b[/link] :boom: \x1b[31mred\x1b]0;title\x07 \x9b2J"
    shown = in_colour(printable(hostile))
    assert shown == printable(hostile)
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]", shown)


@pytest.mark.parametrize(
    ("environment", "tty", "expected"),
    [
        ({}, True, True), ({}, False, False), ({"NO_COLOR": "1"}, True, False),
        ({"NO_COLOR": ""}, True, True), ({"FORCE_COLOR": "1"}, False, True),
        ({"NO_COLOR": "1", "FORCE_COLOR": "1"}, True, False), ({"TERM": "dumb"}, True, False),
    ],
)  # fmt: skip
def test_colours_by_terminal_and_environment(environment, tty, expected, monkeypatch):
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert coloured(Tty() if tty else io.StringIO()) is expected


def test_the_width_is_that_of_the_terminal(monkeypatch):
    assert columns_of(io.StringIO()) is None
    assert columns_of(None) is None
    assert columns_of(Tty()) == 80
    monkeypatch.setenv("COLUMNS", "101")
    assert columns_of(Tty()) == 101
    monkeypatch.setenv("COLUMNS", "5")
    assert columns_of(Tty()) == 20


def test_a_pipe_gets_the_text_as_it_is(monkeypatch, capsys):
    line = "  => " + "word " * 60
    say(line)
    assert capsys.readouterr().out == f"{line}\n"
    monkeypatch.setattr(printing, "drawn", lambda text, stream: text.upper())
    say("a")
    assert capsys.readouterr().out == "A\n"


def on_terminal(*arguments, columns: int, **environment: str) -> str:
    """What a command sends to a terminal."""
    pty = pytest.importorskip("pty")  # not on Windows
    import fcntl
    import struct
    import termios

    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    process = subprocess.Popen(
        [PROGRAM, *arguments], stdin=subprocess.DEVNULL, stdout=slave, stderr=slave,
        env={**os.environ, **environment},
    )  # fmt: skip
    os.close(slave)
    shown = b""
    while True:
        try:
            part = os.read(master, 4096)
        except OSError:  # it is closed
            break
        if not part:
            break
        shown += part
    os.close(master)
    process.wait()
    return shown.decode().replace("\r\n", "\n")


@pytest.mark.parametrize("columns", [60, at_length(80)])
def test_inspect_on_a_terminal_fits_it(pool, columns):
    shown = on_terminal("inspect", pool / "S1-AF", "-q", columns=columns)
    assert "\x1b[1m" in shown
    lines = ESCAPE.sub("", shown).split("\n")
    assert max(map(len, lines)) <= max(
        columns, len(next(x for x in lines if x.startswith("next: ")))
    )
    bare = on_terminal("inspect", pool / "S1-AF", "-q", columns=columns, NO_COLOR="1")
    assert bare == ESCAPE.sub("", shown)
    assert "\x1b" not in printed(PROGRAM, "inspect", pool / "S1-AF")


def test_a_mistake_on_a_terminal_is_in_colour():
    assert on_terminal("inspect", "none", columns=80).startswith(
        "\x1b[1;31mseatrial:\x1b[0m none: "
    )


def test_the_line_of_progress_stays_away_while_a_question_prints():
    """Each line of a question hides it again; only the end of the question shows it."""
    drawn = []

    class Bar:
        def start(self):
            drawn.append("start")

        def stop(self):
            drawn.append("stop")

    line = ProgressLine(io.StringIO())
    line.bar = Bar()
    with line.hidden():
        with line.hidden():
            pass
        with line.hidden():
            pass
        assert drawn == ["stop"]
    assert drawn == ["stop", "start"]
