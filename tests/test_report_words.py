# SPDX-License-Identifier: MIT
"""Numbers and words of a report, as people write them."""

import json

import numpy as np
import pytest

from seatrial.report.figures.embed import decode, encode, pack
from seatrial.report.text.markup import number, unit
from seatrial.report.text.numbers import ratio_word
from seatrial.util.format import joined


def test_columns_keep_five_digits_and_gaps():
    rng = np.random.default_rng(1)
    for scale in (1e-7, 0.3, 1.0, 9.99999, 1e6):
        values = scale * rng.standard_normal(200)
        values[[0, 7, 8, 199]] = np.nan
        back = decode(json.loads(json.dumps(encode(values))))
        assert np.array_equal(np.isnan(back), np.isnan(values))
        assert np.nanmax(np.abs(back - values)) < 1e-4 * np.nanmax(np.abs(values))
    assert np.isnan(decode(encode(np.full(3, np.nan)))).all()
    assert decode(encode(np.zeros(3))).tolist() == [0, 0, 0]
    once = json.loads(pack({"a": [values, {"b": values}], "c": float("nan"), "d": 1.234567}))
    assert once["figures"] == {"a": [{"column": 0}, {"b": {"column": 0}}], "c": None, "d": 1.2346}


@pytest.mark.parametrize(
    ("value", "digits", "expected"),
    [
        (-0.123456, 4, "−0.1235"), (1.0, 4, "1.000"), (12345.6, 3, "1.23·10⁴"), (123.4, 3, "123"),
        (1.5e-7, 2, "1.5·10⁻⁷"), (float("nan"), 3, "–"), (float("inf"), 3, "–"), (0.0, 3, "0.00"),
    ],
)  # fmt: skip
def test_numbers_as_people_write_them(value, digits, expected):
    assert number(value, digits) == expected


def test_words():
    assert [joined(w) for w in ([], ["a"], ["a", "b"], ["a", "b", "c"])] == [
        "", "a", "a and b", "a, b and c",
    ]  # fmt: skip
    ratios = (0.3, 0.7, 0.9, 1.0, 1.2, float("inf"), float("nan"))
    assert [ratio_word(x) for x in ratios] == [
        "well", "fairly", "hardly better than no model", "no better than no model",
        *["worse than no model"] * 3,
    ]  # fmt: skip
    assert unit("rad/m^2") == "rad/m<sup>2</sup>"
