# SPDX-License-Identifier: MIT
"""Threads change no bit of a result, of a fit nor of scores; parallel runs of the tests have one core a worker."""

import os
from threading import Barrier, Event

import numpy as np
import pytest

import seatrial
from seatrial.util.parallel import beside, cores, spread


def test_items_are_worked_on_at_the_same_time(on_cores):
    """Each waits for all."""
    on_cores(3)
    met = Barrier(3, timeout=60.0)
    assert spread(lambda item: (met.wait(), item)[1], "abc") == ["a", "b", "c"]


def test_items_may_have_items_of_their_own(on_cores):
    """More at once than there are threads; each has its share of the cores."""
    on_cores(4)
    own = spread(lambda i: (cores(), spread(lambda k: 10 * i + k, range(5))), range(2))
    assert own == [(2, [0, 1, 2, 3, 4]), (2, [10, 11, 12, 13, 14])]
    deep = spread(
        lambda i: spread(lambda j: spread(lambda k: i + j + k, range(3)), range(3)), range(9)
    )
    assert deep[8] == [[8, 9, 10], [9, 10, 11], [10, 11, 12]]
    assert cores() == 4


def test_the_first_error_is_raised_and_no_further_item_is_begun(on_cores):
    on_cores(2)
    met, begun = Barrier(2, timeout=60.0), []

    def fail(item: int) -> None:
        begun.append(item)
        met.wait()
        raise ValueError(f"item {item}")

    with pytest.raises(ValueError, match="item 0"):
        spread(fail, range(9))
    assert sorted(begun) == [0, 1]
    assert cores() == 2


def test_work_beside_begins_at_once_on_one_core_of_several(on_cores):
    on_cores(2)
    begun = Event()
    result = beside(lambda: (begun.set(), cores())[1])
    assert begun.wait(60.0)
    assert result() == 1

    def fail() -> None:
        raise ValueError("wrong")

    with pytest.raises(ValueError, match="wrong"):
        beside(fail)()


def test_on_one_core_work_beside_is_done_when_its_result_is_wanted(on_cores):
    on_cores(1)
    begun = Event()
    result = beside(lambda: (begun.set(), cores())[1])
    assert not begun.is_set()
    assert result() == 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
def test_a_fork_has_threads_of_its_own(on_cores):
    on_cores(2)
    ready = Event()
    spread(lambda _: ready.wait(60.0) if _ else ready.set(), range(2))  # a thread is there
    if not (child := os.fork()):
        met = Barrier(2, timeout=60.0)
        os._exit(spread(lambda item: (met.wait(), item)[1], range(2)) != [0, 1])
    assert os.waitpid(child, 0)[1] == 0


@pytest.mark.parametrize("method", ["output-error", "equation-error"])
def test_a_model_and_its_scores_are_the_same_on_any_number_of_cores(on_cores, mp, paper_mp, method):
    recordings = [paper_mp[name].recording.cut(0.0, 60.0) for name in ("S1", "S2", "S3")]
    found = []
    for count in (1, 3):
        on_cores(count)
        model = seatrial.identify(recordings, mp, method=method)
        found.append((model, seatrial.validate(model, [paper_mp["S4"].recording.cut(0.0, 60.0)])))
    (model, scores), (other, others) = found
    np.testing.assert_array_equal(model.coefficients, other.coefficients)
    np.testing.assert_array_equal(model.covariance, other.covariance)
    assert model.noise == other.noise
    assert scores == others
