# SPDX-License-Identifier: MIT
"""Progress of long work: shares add up, threads do not mix, the line stays out of the way."""

import io
import itertools
import os
import re
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
from conftest import at_length
from waiting import until

from seatrial.util import progress
from seatrial.util.console import progress_line
from seatrial.util.console.progress_bar import left_text, percent_text, stage_text
from seatrial.util.console.progress_line import ProgressLine
from seatrial.util.parallel import spread
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


def heard(work) -> list[tuple[str, float]]:
    found: list[Status] = []
    with show_progress(found.append):
        work()
    return [(status.stage, round(status.share, 6)) for status in found]


def test_work_that_nobody_listens_to_reports_nothing():
    with progress.stage("reading", 0.5), progress.hidden():
        progress.reach(0.5)
        progress.step(3)
        assert list(progress.over(iter("ab"))) == ["a", "b"]
    assert progress._current.get() is None


def test_shares_of_nested_stages_add_up():
    def work():
        with progress.stage("reading", 0.2):
            for _ in progress.over("ab", "file"):
                progress.reach(0.5)
        with progress.stage("fitting"):
            with progress.stage("search", 0.25):
                pass
            progress.reach(0.75)

    assert heard(work) == [
        ("reading", 0.0),
        ("reading: file 1/2", 0.0),
        ("reading: file 1/2", 0.05),
        ("reading", 0.1),
        ("reading: file 2/2", 0.1),
        ("reading: file 2/2", 0.15),
        ("reading", 0.2),
        ("", 0.2),
        ("fitting", 0.2),
        ("fitting: search", 0.2),
        ("fitting", 0.4),
        ("fitting", 0.8),
        ("", 1.0),
    ]


def test_a_stage_gets_no_more_than_what_is_left():
    def work():
        for share in (0.7, 0.7, 0.7):
            with progress.stage("stage", share):
                pass

    shares = [share for name, share in heard(work) if not name]
    assert shares == [0.7, 1.0, 1.0]


def test_an_exception_of_the_listener_ends_the_work():
    """So a program with a window cancels a long call."""

    class CancelledError(Exception):
        pass

    def report(status):
        if status.share >= 0.5:
            raise CancelledError

    reached = []
    with pytest.raises(CancelledError), show_progress(report):
        for item in progress.over(range(4)):
            reached.append(item)
    assert reached == [0, 1]
    assert progress._current.get() is None


def test_the_share_never_falls():
    def work():
        progress.reach(0.6)
        progress.reach(0.3)

    assert heard(work) == [("", 0.6), ("", 0.6)]


def test_items_without_a_length_need_their_total():
    def work():
        list(progress.over(iter("abcd"), total=4))

    assert [share for _, share in heard(work)][1::2] == [0.25, 0.5, 0.75, 1.0]
    with pytest.raises(ValueError, match="total"):
        heard(lambda: list(progress.over(iter("abcd"))))


def test_steps_of_unknown_number_slow_down_and_never_end():
    def work():
        for _ in range(30):
            progress.step(10)

    shares = [share for _, share in heard(work)]
    assert shares[:8] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8])
    assert all(0.0 < b - a < 0.1 for a, b in itertools.pairwise(shares[8:]))
    assert 0.99 < shares[-1] < 1.0


def test_stages_between_two_steps_divide_the_step():
    def work():
        for name in ("first", "second"):
            progress.step(4, name)
            with progress.stage("fit", 0.5):
                pass
            with progress.stage("check"):
                pass

    assert [(name, share) for name, share in heard(work) if ":" not in name] == [
        ("first", 0.25), ("first", 0.375), ("first", 0.5),
        ("second", 0.5), ("second", 0.625), ("second", 0.75),
    ]  # fmt: skip
    assert ("second: check", 0.625) in heard(work)


def test_a_stage_that_fails_ends():
    def work():
        with suppress(ZeroDivisionError), progress.stage("first", 0.5):
            _ = 1 / 0
        with progress.stage("second", 0.5):
            pass

    assert heard(work) == [("first", 0.0), ("", 0.5), ("second", 0.5), ("", 1.0)]


def test_a_loop_that_is_left_does_not_disturb_later_stages():
    def loop():
        with progress.stage("loop", 0.5):
            items = progress.over("abcd", "item")
            for item in items:
                if item == "b":
                    return items
        return None

    def work():
        items = loop()
        with progress.stage("later"):
            items.close()
            progress.reach(0.5)

    names = [name for name, _ in heard(work)]
    assert names == [
        "loop", "loop: item 1/4", "loop", "loop: item 2/4", "", "later", "later", "",
    ]  # fmt: skip


def test_threads_report_only_to_their_own_listener():
    def work(name):
        for _ in range(50):
            with progress.stage(name, 0.01):
                time.sleep(0.0)

    found: dict[str, list[tuple[str, float]]] = {}

    def listen(name):
        found[name] = heard(lambda: work(name))

    threads = [threading.Thread(target=listen, args=(name,)) for name in "ab"]
    inner = threading.Thread(target=work, args=("inner",))

    def outer():
        for thread in (*threads, inner):
            thread.start()
        for thread in (*threads, inner):
            thread.join()

    assert heard(outer) == []
    for name in "ab":
        assert {one for one, _ in found[name]} == {name, ""}
        assert found[name][-1] == ("", 0.5)


def test_items_in_threads_are_parts_of_the_work_that_spread_them(on_cores):
    on_cores(2)

    def one(item):
        assert progress._current.get() is not None
        progress.reach(0.5)
        return item**2

    def work():
        with progress.stage("fits", 0.8):
            assert spread(one, range(4), "fit") == [0, 1, 4, 9]

    found = heard(work)
    assert found[-1] == ("", 0.8)
    shares = [share for _, share in found]
    assert shares == sorted(shares)
    assert {name for name, _ in found} == {"fits", "fits: fit", ""}
    assert set(shares) >= {0.0, 0.1, 0.8}
    assert heard(lambda: spread(lambda item: item, range(4))) == []


def test_time_left_is_what_the_done_share_took(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    found: list[Status] = []
    with show_progress(found.append):
        for after, share in ((0.5, 0.1), (30.0, 0.01), (30.0, 0.25), (90.0, 1.0)):
            now[0] = 100.0 + after
            progress.reach(share)
    assert [status.left for status in found] == [
        None,
        pytest.approx(29.5 * 9),  # since the first report
        pytest.approx(29.5 * 3),
        0.0,
    ]


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


def drawn(stage: str, share: float, columns: int, monkeypatch) -> tuple[Terminal, ProgressLine]:
    """A line that is on a terminal of so many columns since 10 s."""
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setattr(progress_line, "LINE_AFTER", 0.0)
    terminal = Terminal()
    line = ProgressLine(terminal)
    line.begun = time.monotonic() - 10.0
    line.update(Status(stage, share, None))
    until(lambda: percent_text(line.status) in terminal.shown())
    return terminal, line


def test_the_line_is_drawn_over_and_removed_for_what_is_printed(monkeypatch):
    terminal, line = drawn("a long name of a stage", 0.5, 60, monkeypatch)
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
def test_the_line_is_never_wider_than_the_terminal(columns, monkeypatch):
    terminal, line = drawn("x" * 200, 0.5, columns, monkeypatch)
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


def test_names_from_files_are_no_markup_and_no_escape_sequence(monkeypatch):
    terminal, line = drawn("[red]a[/red] \x1b[2J\x9b1A :boom:", 0.5, 80, monkeypatch)
    assert terminal.shown().startswith("[red]a[/red] ?[2J?1A :boom: ")
    line.__exit__()


def test_a_terminal_shows_long_work_only_and_is_clean_at_its_end(monkeypatch):
    terminal = Terminal()
    monkeypatch.setenv("TERM", "xterm-256color")
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
    command = [Path(sys.executable).parent / "seatrial", "simulate", "--out", tmp_path]
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


def test_nothing_is_drawn_on_a_terminal_that_only_appends(monkeypatch):
    terminal = Terminal()
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setattr(progress.sys, "stderr", terminal)
    monkeypatch.setattr(progress_line, "LINE_AFTER", 0.0)
    with show_progress(), progress.stage("long"):
        time.sleep(0.3)
    assert terminal.getvalue() == ""


def test_nothing_is_drawn_where_standard_error_is_a_file(monkeypatch):
    plain = io.StringIO()
    monkeypatch.setattr(progress.sys, "stderr", plain)
    monkeypatch.setattr(progress_line, "LINE_AFTER", 0.0)
    with show_progress(), progress.stage("piped"):
        assert progress._current.get() is None
    assert plain.getvalue() == ""
