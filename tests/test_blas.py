# SPDX-License-Identifier: MIT
"""BLAS keeps to one thread while a model is computed, and has its own number before and after."""

import pytest
from threadpoolctl import ThreadpoolController, threadpool_info, threadpool_limits

import seatrial
from seatrial.identification import methods
from seatrial.identification.selection.terms import select_terms

TWO = 2
OF_SECONDS = (
    seatrial.auto, seatrial.compare, seatrial.init, seatrial.inspect, seatrial.tune, seatrial.validate,
    methods.identify_with_fit, select_terms.select,
)  # fmt: skip


def threads():
    """Of each BLAS that is loaded."""
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def with_two():
    with threadpool_limits(TWO, user_api="blas"):
        yield
        assert threads() == {TWO}


def test_identify_holds_the_limit(monkeypatch, mp):
    seen = []
    own = methods.check_recordings
    monkeypatch.setattr(
        methods, "check_recordings", lambda *given: (seen.append(threads()), own(*given))
    )
    with pytest.raises(seatrial.SeatrialError):
        seatrial.identify([], mp)
    assert seen == [{1}]


@pytest.mark.parametrize("function", OF_SECONDS, ids=lambda f: f.__name__)
def test_a_refusal_gives_the_limit_back(monkeypatch, function):
    """Each of the functions that compute for seconds takes it; after an error, too, the fixture finds two."""
    taken = []
    own = ThreadpoolController.limit
    monkeypatch.setattr(
        ThreadpoolController,
        "limit",
        lambda *a, **limit: (taken.append(limit), own(*a, **limit))[1],
    )
    with pytest.raises((seatrial.SeatrialError, TypeError, AttributeError)):
        function(None, None)
    assert taken[0] == {"limits": 1, "user_api": "blas"}
