# SPDX-License-Identifier: MIT
"""What the verdict says of errors that are smaller than the model states."""

from types import SimpleNamespace

import numpy as np
import pytest

from seatrial.boat.schema import RecordingEntry
from seatrial.report.evidence import verdict


@pytest.fixture(autouse=True)
def _expected(monkeypatch):
    monkeypatch.setattr(verdict, "expected_rms", lambda _: np.ones(3))


def said(rms, **effects):
    entry = RecordingEntry("S1", 60.0, effects=effects)
    model = SimpleNamespace(recordings=(entry,))
    return verdict._over_expected(model, [], rms * np.ones(3))


def test_a_cautious_model_is_told_so():
    assert said(0.5).endswith(
        ": 0.50, 0.50 and 0.50: the model states larger errors than it makes."
    )


def test_an_estimated_current_explains_it():
    text = said(0.1, current_x=0.1, current_y=0.0, trim_u=0.01)
    assert text.endswith("0.10, which allows for an unknown current and trim.")


def test_errors_as_expected_need_no_words():
    assert said(0.9, current_x=0.1).endswith("expected RMS: 0.90, 0.90 and 0.90.")
