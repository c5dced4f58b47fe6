# SPDX-License-Identifier: MIT
"""Findings as values: each kind through a file and back, what is refused, and the text of each."""

import copy
import io
import pickle
import string
from dataclasses import replace

import msgspec
import pytest
import yaml
from conftest import TABLE_II, make_model
from hypothesis import given
from hypothesis import strategies as st

from seatrial.boat.finding_kinds import PART_CHOICES
from seatrial.boat.finding_texts.spec import NAMES, Spec
from seatrial.boat.findings import (
    MOST_NAMES,
    Finding,
    FindingKind,
    finding_of,
    finding_text,
    of_kinds,
)
from seatrial.boat.model_file import load, save
from seatrial.boat.schema import EstimatorEntry
from seatrial.util.errors import SeatrialError
from seatrial.util.files import convert, dump_yaml, read_yaml

HOSTILE = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=30)
SIMPLE = {"lag", "S1", "{subject}", "%s", "a: b", "- x", "'", "0.1", "true", "~", "\n"}


def values_of(spec: Spec, count: int, number: float = 0.125) -> dict[str, object]:
    """Values that a finding with so many subjects may have."""
    numbers = {name: (number,) * count if name in spec.each else number for name in spec.numbers}
    words = {name: next(iter(choices or {"any": ""})) for name, choices in spec.words.items()}
    return {**numbers, **words}


def example(kind: FindingKind, names: str = "S1", number: float = 0.125) -> Finding:
    """A finding of a kind whose subject is this name, where its parts are not one of few."""
    spec = kind.spec
    subject = [PART_CHOICES.get(part, (names,))[0] for part in spec.subject]
    if NAMES in spec.subject.values():
        subject.append(PART_CHOICES.get(list(spec.subject)[-1], (names,))[-1])
    return Finding(kind, tuple(subject), values_of(spec, len(subject), number))


@pytest.mark.parametrize("kind", FindingKind)
def test_every_kind_is_the_same_after_a_model_file(kind, mp, tmp_path):
    model = make_model(mp, TABLE_II["MP"])
    entry = msgspec.structs.replace(model.estimator, findings=[example(kind)])
    save(replace(model, estimator=entry), tmp_path / "model.yaml")
    again = load(tmp_path / "model.yaml")
    assert again.estimator.findings == [example(kind)]
    assert again.findings_of(kind) == (example(kind),)
    save(again, tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_bytes() == (tmp_path / "model.yaml").read_bytes()


@pytest.mark.parametrize("kind", FindingKind)
def test_every_kind_says_what_was_found_and_what_to_do(kind):
    """All that a sentence names is there, and all that is there is named."""
    named = {
        field
        for text in (kind.sentence, kind.advice)
        for _, field, _, _ in string.Formatter().parse(text)
        if field
    }
    spec = kind.spec
    known = {*spec.subject, *spec.numbers, *spec.words}
    assert {name.removesuffix("_means").removesuffix("_quoted") for name in named} == known
    assert bool(kind.advice) == (kind is not FindingKind.OTHER)
    text = finding_text(example(kind))
    assert "{" not in text.replace("{gains: {S1: 0.125, S1: 0.125}}", "")
    assert not text.endswith(".")
    for sentence in text.split(". "):
        assert len(sentence.split()) <= 40, sentence


@given(HOSTILE | st.sampled_from(sorted(SIMPLE)), st.sampled_from(list(FindingKind)))
def test_a_name_is_the_same_after_a_file_whatever_it_is(name, kind):
    finding = example(kind, name)
    entry = EstimatorEntry("output-error", findings=[finding])
    text = dump_yaml(msgspec.to_builtins(entry))

    class Stored:
        """A file that is not on disk."""

        def open(self, mode: str) -> io.BytesIO:
            assert mode == "rb"
            return io.BytesIO(text.encode("utf-8"))

    assert convert(read_yaml(Stored()), EstimatorEntry, "file") == entry
    assert finding_text(finding).isprintable()


@given(st.floats(1e-12, 1e12), st.sampled_from(list(FindingKind)))
def test_every_number_has_a_text(number, kind):
    assert finding_text(example(kind, number=number)).isprintable()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"kind": "at-bounds"}, "findings.*kind: got 'at-bounds'; expected .*at-bound"),
        ({"kind": "at-bound", "subject": "lag"}, "expected a list"),
        ({"kind": "at-bound", "values": {"bound": 0.1}}, "at-bound has 0 subjects; expected parameter"),
        ({"kind": "at-bound", "subject": ["lag"]}, "at-bound has values none; expected bound"),
        ({"kind": "at-bound", "subject": ["a", "b"], "values": {"bound": 0.1}}, "has 2 subjects"),
        ({"kind": "at-bound", "subject": [""], "values": {"bound": 0.1}}, "a subject is empty"),
        ({"kind": "at-bound", "subject": ["lag"], "values": {"bound": "0.1"}}, "not a finite number"),
        ({"kind": "at-bound", "subject": ["lag"], "values": {"bound": [0.1]}}, "must be a number"),
        ({"kind": "at-bound", "subject": ["lag"], "values": {"bound": 1.0, "b": 2.0}}, "expected bound"),
        ({"kind": "at-bound", "subject": ["lag"], "values": {"bound": float("nan")}}, "not a finite"),
        ({"kind": "at-bound", "subject": ["x" * 20_000], "values": {"bound": 1.0}}, "too long"),
        ({"kind": "at-bound", "subjects": ["lag"]}, "unknown key 'subjects'"),
        ({"kind": "outliers", "values": {"share": -0.1}}, "share is -0.1; expected at least 0"),
        ({"kind": "outliers", "values": {"share": True}}, "expected a number|got `bool`|got 'bool'"),
        ({"kind": "other", "values": {"text": 1.0}}, "text must be text"),
        ({"kind": "other", "values": {"text": "x" * 20_000}}, "at most 10000 characters"),
        (
            {"kind": "no-better-than-constant", "subject": ["surge", "heave"]},
            "axes is 'heave'; expected surge, sway, yaw",
        ),
        (
            {"kind": "curve-stage-selected", "values": {"stage": "gain"}},
            "stage is 'gain'; expected reverse_ratio, power",
        ),
        (
            {"kind": "prior-dominates", "subject": ["a"] * (MOST_NAMES + 1)},
            "its subject is too long",
        ),
        (
            {
                "kind": "unequal-thruster-gains",
                "subject": ["a", "b"],
                "values": {"gains": [1.0], "weak": "one"},
            },
            "gains must be a number for each subject",
        ),
    ],
)  # fmt: skip
def test_a_finding_in_a_file_that_can_not_be_is_one_clear_line(mp, tmp_path, content, words):
    path = tmp_path / "model.yaml"
    save(make_model(mp, TABLE_II["MP"]), path)
    file = yaml.safe_load(path.read_text())
    file["estimator"]["findings"] = [content]
    path.write_text(yaml.safe_dump(file))
    with pytest.raises(SeatrialError, match=words) as caught:
        load(path)
    assert "\n" not in str(caught.value)


def test_a_finding_can_not_be_changed():
    finding = finding_of(FindingKind.AT_BOUND, "lag", bound=0.002)
    for change in (
        lambda: finding.values.update(bound=1.0),
        lambda: finding.values.pop("bound"),
        lambda: finding.values.__setitem__("bound", 1.0),
        finding.values.clear,
    ):
        with pytest.raises(TypeError, match="can't be changed"):
            change()
    with pytest.raises(AttributeError):
        finding.kind = FindingKind.OTHER
    assert finding.values == {"bound": 0.002}


def test_a_finding_is_a_value():
    """Equal, hashable, the same in another process."""
    one, same = (finding_of(FindingKind.AT_BOUND, "lag", bound=0) for _ in range(2))
    other = finding_of(FindingKind.AT_BOUND, "lag", bound=1)
    assert one == same != other
    assert {one, same, other} == {one, other}
    for again in (pickle.loads(pickle.dumps(one)), copy.deepcopy(one)):
        assert again == one
        with pytest.raises(TypeError):
            again.values.clear()
    assert of_kinds([one, example(FindingKind.OTHER)], FindingKind.AT_BOUND) == (one,)


def test_values_of_a_parameter_have_the_sign_of_the_axes_that_are_shown():
    numbers = {"prior": -0.2, "prior_error": 0.04, "found": -0.4, "found_error": 0.01}
    finding = finding_of(FindingKind.PRIOR_CONFLICT, "Y_r", **numbers)
    assert "Y_r changed from -0.2 ± 0.04 to -0.4 ± 0.01" in finding_text(finding)
    assert "Y_r changed from 0.2 ± 0.04 to 0.4 ± 0.01" in finding_text(finding, {"Y_r", "N_v"})
    assert finding_text(finding, {"N_v"}) == finding_text(finding)
    assert finding.in_axes({"Y_r"}).in_axes({"Y_r"}) == finding


def test_some_texts_as_they_are_shown():
    assert finding_text(finding_of(FindingKind.AT_BOUND, "lag", bound=0.002)).startswith(
        "lag: the estimate is at the bound 0.002 of its range"
    )
    gains = finding_of(FindingKind.UNEQUAL_THRUSTER_GAINS, "a", "b", gains=(0.8, 1.2), weak="one")
    assert "add {gains: {a: 0.8, b: 1.2}} to the vehicle file's chain" in finding_text(gains)
    hand = finding_of(FindingKind.DISTURBED_INTERVAL, "S1 morning", start=0.0, end=12.5, ratio=3.2)
    assert finding_text(hand) == (
        "external disturbance: innovations are 3.2 times larger than elsewhere in S1 morning from 0 s to "
        "12.5 s. If the boat was held, carried or bumped there, or a thruster stopped, exclude it with "
        "--without 'S1 morning'=0-12.5"
    )
    offset = finding_of(FindingKind.HEADING_OFFSET, size=0.0698, psi_offset=-0.0698)
    assert "a heading that is 4 degrees off" in finding_text(offset)
    assert "offset: -0.0698 at pose: psi" in finding_text(offset)
