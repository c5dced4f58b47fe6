# SPDX-License-Identifier: MIT
"""Progress of long work: shares add up, threads do not mix."""

import itertools
import threading
import time
from contextlib import suppress

import pytest

from seatrial.util import progress
from seatrial.util.parallel import spread
from seatrial.util.progress import show_progress
from seatrial.util.status import Status


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
