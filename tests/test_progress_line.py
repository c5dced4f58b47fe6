# SPDX-License-Identifier: MIT
"""The line of progress: what it says, where it is drawn, that it stays out of the way of what is printed."""

import io
import os
import re
import subprocess
import threading
import time
from contextlib import suppress

import pytest
from conftest import at_length
from programs import PROGRAM
from waiting import until

from seatrial.util import progress
from seatrial.util.console import progress_line
from seatrial.util.console.progress_bar import left_text, percent_text, stage_text
from seatrial.util.console.progress_line import ProgressLine
from seatrial.util.progress import show_progress
from seatrial.util.status import Status, duration_text


class Terminal(io.StringIO):
    """A stream that says it is one, and the line it shows after all it was sent."""

    def isatty(self) -> bool:
        return True

    def shown(self) -> str:
        rows, at, column = [[]], 0, 0
        for control, letter in re.findall(r"\x1b\[([\d;?]*[A-Za-z])|([\s\S])", self.getvalue()):
            if control == "2K":
                rows[at] = []
            elif control == "1A":
                at -= 1
            elif letter == "\r":
                column = 0
            elif letter == "\n":
                at, column = at + 1, 0
                rows += [[] for _ in range(at + 1 - len(rows))]
            elif letter:
                rows[at][len(rows[at]) :] = " " * (column - len(rows[at]))
                rows[at][column : column + 1] = letter
                column += 1
            else:
                assert control.endswith("m"), control  # colours; the cursor is never hidden
        return "\n".join("".join(row).rstrip() for row in rows).rstrip()


def test_time_left_begins_with_a_fifth_and_is_without_the_time_for_answers(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    found: list[Status] = []
    with show_progress(found.append):
        progress.reach(0.1)
        now[0] = 112.0
        progress.reach(0.19)
        with progress.hidden(), progress.hidden():  # a question prints within
            now[0] = 412.0
        now[0] = 413.0
        progress.reach(0.25)
    assert [status.left for status in found] == [None, None, pytest.approx(13.0 * 3)]
    line = ProgressLine(Terminal())
    line.begun = now[0]
    with line.hidden(), line.hidden():
        now[0] += 300.0
    now[0] += 12.0
    assert left_text(Status("", 0.25, None), line.begun) == "36 s left"
    assert left_text(Status("", 0.19, None), line.begun) == ""
    now[0] += 60.0  # long work
    assert left_text(Status("", 0.1, None), line.begun) == "10 min 48 s left"


def test_the_line_says_stage_percentage_and_time_left(monkeypatch):
    assert percent_text(Status("reading", 0.123, None)) == "12 %"
    monkeypatch.setattr(progress.time, "monotonic", lambda: 159.6)
    assert left_text(Status("", 0.5, None), 100.0) == "1 min 0 s left"
    assert left_text(Status("", 0.04, None), 100.0) == ""  # too early
    texts = [duration_text(s) for s in (0.4, 59.4, 125.0, 3599.6, 3780.0)]
    assert texts == ["0 s", "59 s", "2 min 5 s", "1 h 0 min", "1 h 3 min"]


@pytest.fixture
def terminal(monkeypatch) -> Terminal:
    """One on which work is shown at once."""
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setattr(progress_line, "LINE_AFTER", 0.0)
    return Terminal()


@pytest.fixture
def drawn(terminal, monkeypatch):
    """A line that is on the terminal of so many columns since 10 s."""

    def draw(stage: str, columns: int) -> ProgressLine:
        monkeypatch.setenv("COLUMNS", str(columns))
        line = ProgressLine(terminal)
        line.begun = time.monotonic() - 10.0
        line.update(Status(stage, 0.5, None))
        until(lambda: percent_text(line.status) in terminal.shown())
        return line

    return draw


def test_the_line_is_drawn_over_and_removed_for_what_is_printed(terminal, drawn):
    line = drawn("a long name of a stage", 60)
    found = re.fullmatch(r"a long name of a stage  +50 % (\d+) s left", terminal.shown())
    assert found and int(found[1]) >= 10  # as long as the first half took
    line.update(Status("short", 0.99, None))
    until(lambda: re.fullmatch(r"short  +99 % \d+ s left", terminal.shown()))
    with line.hidden():
        assert terminal.shown() == ""
        time.sleep(0.6)  # longer than between two drawings
        assert terminal.shown() == ""
        terminal.write("printed\n")
    until(lambda: re.fullmatch(r"printed\nshort  +99 % \d+ s left", terminal.shown()))
    line.__exit__()
    assert terminal.shown() == "printed"


@pytest.mark.parametrize("columns", [30, 60, 80, 120])
def test_the_line_is_never_wider_than_the_terminal(columns, terminal, drawn):
    line = drawn("x" * 200, columns)
    shown = terminal.shown()
    line.__exit__()
    assert "\n" not in shown
    assert len(shown) <= columns
    found = re.search(r"^x+… .*50 % (\d+) s left$", shown)
    assert found and int(found[1]) >= 10
    assert ("━" in shown) == (columns >= 76)


def test_the_inner_stage_is_shown_where_not_all_fit():
    assert stage_text("a: bb: ccc", 20) == "a: bb: ccc"
    assert stage_text("a: bb: ccc", 9) == "… bb: ccc"
    assert stage_text("a: bb: ccc", 8) == "… ccc"
    assert stage_text("a: bb: ccc", 1) == "… ccc"  # cut where it is drawn
    assert stage_text("cccccc", 3) == "cccccc"


def test_names_from_files_are_no_markup_and_no_escape_sequence(terminal, drawn):
    line = drawn("[red]a[/red] \x1b[2J\x9b1A :boom:", 80)
    assert terminal.shown().startswith("[red]a[/red] ?[2J?1A :boom: ")
    line.__exit__()


def test_a_terminal_shows_long_work_only_and_is_clean_at_its_end(terminal, monkeypatch):
    monkeypatch.setattr(progress.sys, "stderr", terminal)
    monkeypatch.setattr(progress_line, "LINE_AFTER", 3600.0)
    with show_progress(), progress.stage("short"):
        time.sleep(0.05)
    assert terminal.getvalue() == ""
    monkeypatch.setattr(progress_line, "LINE_AFTER", 0.0)
    with show_progress(quiet=True), progress.stage("quiet"):
        time.sleep(0.05)
    assert terminal.getvalue() == ""
    with show_progress(), progress.stage("long"):
        until(lambda: re.fullmatch(r"long .* 0 %", terminal.shown()))
        with progress.hidden():
            assert terminal.shown() == ""
    assert terminal.shown() == ""
    assert "progress" not in {thread.name for thread in threading.enumerate()}


@pytest.mark.parametrize("quiet", [pytest.param(False, id="shown"), at_length(True, id="quiet")])
def test_a_command_shows_its_progress_on_a_terminal(quiet, tmp_path):
    pty = pytest.importorskip("pty")  # not on Windows
    master, slave = pty.openpty()
    command = [PROGRAM, "simulate", "--out", tmp_path]
    process = subprocess.Popen(
        [*command, *(["--quiet"] if quiet else [])], stderr=slave, stdout=subprocess.PIPE, text=True
    )
    os.close(slave)
    shown = ""
    with suppress(OSError):  # it is closed
        while part := os.read(master, 4096):
            shown += part.decode()
    os.close(master)
    out, _ = process.communicate()
    assert process.returncode == 0
    assert out.count("S7-") == 2
    if quiet:
        assert shown == ""
        return
    found = re.findall(
        r"simulating trial \d/7 [^%\r]*?(\d+) %", re.sub(r"\x1b\[[\d;]*m", "", shown)
    )
    assert [int(share) for share in found] == sorted(map(int, found))
    assert found
    screen = Terminal()
    screen.write(shown)
    assert screen.shown() == ""


def test_nothing_is_drawn_on_a_terminal_that_only_appends(terminal, monkeypatch):
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setattr(progress.sys, "stderr", terminal)
    with show_progress(), progress.stage("long"):
        time.sleep(0.3)
    assert terminal.getvalue() == ""


def test_nothing_is_drawn_where_standard_error_is_a_file(terminal, monkeypatch):
    monkeypatch.setattr(progress.sys, "stderr", plain := io.StringIO())
    with show_progress(), progress.stage("piped"):
        assert progress._current.get() is None
    assert plain.getvalue() == ""
