# SPDX-License-Identifier: MIT
"""docs/identify.md: its commands run, print what it shows, and its notes are the program's."""

import contextlib
import io
import re
import shlex

import numpy as np
import pytest
from test_docs import ROOT, blocks

import seatrial
from seatrial.boat.findings import FindingKind
from seatrial.commands.cli import main

pytestmark = pytest.mark.system
PAGE = ROOT / "docs" / "identify.md"
NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
REPLICATES = "40"  # instead of the page's 200: the same code, ten times as fast


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """What each command of the page prints, and where they ran."""
    folder = tmp_path_factory.mktemp("identify")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        found = []
        for line in "".join(blocks(PAGE, "sh")).splitlines():
            program, *arguments = shlex.split(line, comments=True)
            assert program == "seatrial"
            arguments = [REPLICATES if a == "200" else a for a in arguments]
            with contextlib.redirect_stdout(io.StringIO()) as out:
                assert main([*arguments, "--quiet"]) == 0, line
            found.append(out.getvalue())
    return folder, found


def parts(line: str) -> tuple[str, np.ndarray]:
    """A line's words, and its numbers."""
    words = " ".join(re.sub(NUMBER, "#", line).split())
    return words, np.array([float(x) for x in re.findall(NUMBER, line)])


def test_the_summary_is_the_one_shown(shown):
    printed = dict(parts(line) for line in shown[1][1].splitlines())
    assert "What matters most" not in printed
    for line in blocks(PAGE, "")[0].splitlines():
        words, numbers = parts(line)
        assert words in printed
        np.testing.assert_allclose(numbers, printed[words], rtol=0.2, atol=1e-12, err_msg=line)


def test_every_option_shows_what_it_is_for(shown):
    folder, (_, plain, minutes, profile, bootstrap, effects, prior, paper) = shown
    assert "more for half" in minutes
    assert re.search(r"lag +0\.08\d+ ± 0\.\d+ +0\.0[78]\d+ +0\.08\d+", profile)
    assert f"bootstrap of {REPLICATES}" in bootstrap
    assert "the measured point is" in effects
    assert "S1-MP: current_x" in effects
    assert "prior: an older model" in prior
    assert "± covers scatter only" in paper
    assert "more for half" not in plain
    lever = seatrial.load(folder / "model.yaml").vehicle.file.pose.lever
    np.testing.assert_allclose(lever, 0.0, atol=1e-3)


OF_SCORES = {  # docs/validate.md has them
    FindingKind.NO_FILTER,
    FindingKind.HORIZON_NOT_PREDICTED,
    FindingKind.EXCEEDS_EXPECTED_ERROR,
    FindingKind.SLOW_POSES,
    FindingKind.THROUGH_WATER,
}


def messages(heading: str) -> list[str]:
    """The first column of a section's table, message by message."""
    rows = PAGE.read_text().split(heading)[1].split("\n## ")[0].splitlines()
    cells = [row.split("|")[1].strip() for row in rows if row.startswith("| ")][1:]
    return [message.strip() for cell in cells for message in cell.split(";") if cell != "---"]


def test_every_finding_is_in_the_table_as_it_is_worded():
    said = {kind: re.sub(r"\{[^{}]*\}", "…", kind.sentence) for kind in FindingKind}
    found = {
        message: {kind for kind, sentence in said.items() if sentence.startswith(message)}
        for message in messages("## Notes")
    }
    (of_inspect,) = (message for message, kinds in found.items() if not kinds)
    assert of_inspect == "… contradicts the vehicle file"
    assert all(len(kinds) <= 1 for kinds in found.values())
    listed = {kind for kinds in found.values() for kind in kinds}
    assert listed == set(FindingKind) - OF_SCORES - {FindingKind.OTHER}


def test_the_refusals_are_those_that_the_program_makes():
    sources = " ".join(
        re.sub(r'"\s*f?"', "", path.read_text()) for path in (ROOT / "src").rglob("*.py")
    )
    said = [*messages("## When it refuses"), "… contradicts the vehicle file"]
    assert len(said) > 6
    for message in said:
        for piece in re.split(r"…|\b\d+\b", message):
            assert piece.strip(" %:,") in sources, piece
