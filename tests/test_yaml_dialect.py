# SPDX-License-Identifier: MIT
"""Numbers and words of YAML files: read as a person means them, written as other readers take them."""

import numpy as np
import pytest
import yaml

from seatrial.util.files import dump_yaml, read_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [("01500", 1500), ("0", 0), ("-007", -7), ("+12", 12), ("08", 8), ("0o17", 15), ("0x1F", 31), ("1:30", "1:30"),
     ("1_000", "1_000"), ("0b11", "0b11"), ("1500.0", 1500.0), ("1e3", 1e3), ('"01500"', "01500")],
)  # fmt: skip
def test_whole_numbers_are_decimal(tmp_path, text, value):
    (tmp_path / "a.yaml").write_text(f"a: {text}\n")
    found = read_yaml(tmp_path / "a.yaml")["a"]
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    "word",
    ["01500", "08", "0o17", "0x1F", "1:30", "1_000", "0b11", "12", "1e3", "-", "+1", "on", ".5"],
)
def test_words_that_look_like_numbers_are_written_as_words(tmp_path, word):
    content = {"a": word, "b": [word, 1], word: 2}
    (tmp_path / "a.yaml").write_text(dump_yaml(content))
    assert read_yaml(tmp_path / "a.yaml") == content
    assert yaml.safe_load(dump_yaml({"a": word}))["a"] == word or word in ("08", "0o17")


@pytest.mark.parametrize("value", [1e-5, -2e-7, 1e20, 5e-324, 3.0, 0.0, np.inf, -np.inf])
def test_a_number_is_one_to_other_readers_of_yaml(value):
    """YAML 1.1, as of `rosparam load`, takes 1e-05 for a word."""
    got = yaml.safe_load(dump_yaml({"value": value}))["value"]
    assert isinstance(got, float)
    assert got == pytest.approx(value, rel=1e-9)
