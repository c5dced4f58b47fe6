# SPDX-License-Identifier: MIT
"""docs/identify.md: its commands run and print what it shows."""

import contextlib
import io
import re
import shlex

import numpy as np
import pytest
from test_docs import ROOT, blocks

import seatrial
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
            if arguments[0] == "simulate":
                arguments += ["--vehicle", "mallard-mp"]  # the page reads no trial of the other
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
