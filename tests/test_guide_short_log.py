# SPDX-License-Identifier: MIT
"""auto of a log that is just long enough for a model: nothing is held out of it."""

from sheets import two_sheets
from survey_boat import TRUTH, as_stated, both, driven

import seatrial


def test_a_minute_is_used_as_a_whole(tmp_path):
    """Three quarters of it were refused as too short, with the advice to drive a minute."""
    log = tmp_path / "log"
    log.mkdir()
    _, recording = driven({}, [both] * 2, seconds=62.0)
    two_sheets(log, recording, "left", "right")
    found = seatrial.auto([log], tmp_path / "boat")
    (said,) = (text for text in found.assumed if text.startswith("nothing is held out"))
    assert "46 s in all is too short for 15 parameters" in said
    (used,) = found.model.recordings
    assert used.length > 61.0
    assert as_stated(found.model, {n: TRUTH[n] for n in ("X_u", "X_F", "N_r", "N_F")}) == {}
