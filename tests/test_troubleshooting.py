# SPDX-License-Identifier: MIT
"""The page of messages: every finding, fault and flag is there, every error that it names is in the program."""

import ast
import re
import sys
from functools import cache

import pytest
from test_docs import ROOT

import seatrial
from seatrial.boat.findings import FindingKind, finding_of, finding_text
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.onboard.predictor import Health
from seatrial.recording.faults.pose_faults import FaultKind

sys.path.insert(0, str(ROOT / "tools"))
import troubleshooting

PAGE = troubleshooting.page()


@cache
def messages() -> str:
    """Strings of the program, a line each, … for what is filled in."""
    found = []
    for path in (ROOT / "src" / "seatrial").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.JoinedStr):
                parts = [p.value if isinstance(p, ast.Constant) else "…" for p in node.values]
                found.append("".join(parts))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.append(node.value)
    return "\n".join(found)


def test_a_message_is_found_by_its_words():
    (entry,) = troubleshooting.found("directions have the same edge").split("\n- ")
    assert entry.startswith("- `dead zone of …: both directions have the same edge")
    assert "**Do:**" in entry
    assert troubleshooting.found("no such words") == ""
    assert troubleshooting.found("").count("\n- ") > len(FindingKind)


def test_every_finding_has_a_meaning_and_stands_on_the_page_with_its_advice():
    known = [kind for group in troubleshooting.MEANINGS.values() for kind in group]
    assert sorted(k.value for k in known) == sorted({k.value for k in FindingKind} - {"other"})
    for kind in known:
        entry = next(
            e
            for e in PAGE.split("\n- ")
            if e.startswith(f"`{troubleshooting.told(kind.sentence)}`")
        )
        assert troubleshooting.told(kind.advice) in entry
        assert not re.search(r"\{[a-z_]+[}:]", troubleshooting.told(kind.sentence))


@pytest.mark.parametrize(
    "finding",
    [
        finding_of(FindingKind.AT_BOUND, "lag", bound=0.002),
        finding_of(FindingKind.DISTURBED_INTERVAL, "S1", start=3.0, end=4.5, ratio=4.0),
        finding_of(
            FindingKind.UNEQUAL_THRUSTER_GAINS, "left", "right", gains=(0.9, 1.1), weak="one"
        ),
        finding_of(FindingKind.OUTLIERS, share=0.031),
        finding_of(FindingKind.HEADING_OFFSET, size=0.1, psi_offset=-0.1),
    ],
    ids=lambda finding: finding.kind.value,
)
def test_words_of_a_printed_finding_are_found_on_the_page(finding):
    """The entry of its kind, as a pattern, matches what is printed."""
    parts = [troubleshooting.told(text) for text in (finding.kind.sentence, finding.kind.advice)]
    assert all(part in PAGE for part in parts)
    sentence = re.escape(parts[0]).replace("…", ".*")
    assert re.match(sentence, finding_text(finding))


def test_every_fault_and_every_flag_is_on_the_page():
    assert set(troubleshooting.FAULTS) == set(FaultKind)
    for kind in FaultKind:
        assert f"- `{kind.value}`" in PAGE
    for flag in Health:
        assert f"- `{flag.names[0]}`" in PAGE
        assert all(part in PAGE for part in flag.advice[0].rstrip(".")[1:].split(". "))


@pytest.mark.parametrize("group", troubleshooting.ERRORS)
def test_every_error_on_the_page_is_one_of_the_programs(group):
    known = messages()
    for message, meaning, advice in troubleshooting.ERRORS[group]:
        assert message in known, message
        assert f"- `{message}`  \n  {meaning}  \n  **Do:** {advice}" in PAGE


def test_every_contradiction_of_the_vehicle_file_is_on_the_page():
    assert set(troubleshooting.CONTRADICTIONS) == set(InconsistencyKind)
    for message, meaning, advice in troubleshooting.CONTRADICTIONS.values():
        assert message in messages(), message
        assert f"- `{message}`  \n  {meaning}  \n  **Do:** {advice}" in PAGE
    assert "commands: inputs" in troubleshooting.found("swapped")


def test_commands_and_extras_in_the_advice_exist():
    from seatrial.commands import COMMANDS

    for command in re.findall(r"`seatrial (\w+)", PAGE):
        assert command in COMMANDS
    declared = (ROOT / "pyproject.toml").read_text()
    for extra in re.findall(r"seatrial\[(\w+)\]", PAGE):
        assert f"\n{extra} = [" in declared
    assert seatrial.__all__
