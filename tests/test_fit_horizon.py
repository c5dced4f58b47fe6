# SPDX-License-Identifier: MIT
"""The fit horizon under model mismatch: candidates are compared by errors one second ahead."""

from dataclasses import replace

import numpy as np
from survey_boat import both, driven

from seatrial.identification.estimator import OutputErrorSettings, fit
from seatrial.identification.likelihood.fit_horizon import held_out_errors


def test_a_candidate_that_diverges_has_no_errors_and_ends_no_identification():
    """As of a heading that is the course over ground: no boat moves so."""
    vehicle, drive = driven({}, [both, both], seconds=80.0)
    at = fit([drive], vehicle, settings=OutputErrorSettings(select_stages=False)).point
    errors = held_out_errors(at)
    assert errors is not None and np.isfinite(errors).all()
    theta = at.theta.copy()
    theta[at.runs.problem.names.index("X_uu")] = 50.0  # drag that drives
    assert held_out_errors(replace(at, theta=theta)) is None
