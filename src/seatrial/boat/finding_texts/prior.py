# SPDX-License-Identifier: MIT
"""Findings on a prior model."""

from seatrial.boat.finding_texts.spec import NAMES, ONE_NAME, QUANTITIES, Spec

PRIOR_OFF = (
    "Either the boat changed more than --prior-spread, or the recording is bad: take a larger "
    "--prior-spread, or record as for a new model"
)

PRIOR_USED = Spec(
    "prior: an older model, widened by {spread:.2g%} of every parameter",
    "Choose the change that you expect with --prior-spread",
    numbers={"spread": "-"},
)
PRIOR_CONFLICT = Spec(
    "prior and recording disagree: {parameter} changed from {prior:.3g} ± {prior_error:.2g} to "
    "{found:.3g} ± {found_error:.2g}",
    PRIOR_OFF,
    {"parameter": ONE_NAME},
    dict.fromkeys(("prior", "prior_error", "found", "found_error"), "of the parameter"),
    signed=("prior", "found"),
    parameter=("prior", "found"),
)
PRIOR_FACTOR = Spec(
    "prior and recording disagree: {quantity} in {axis} is {factor:.2f} times the prior's",
    PRIOR_OFF,
    {"axis": ONE_NAME},
    {"factor": "-"},
    {"quantity": QUANTITIES},
    signed=("factor",),
)
ADAPTED = Spec(
    "adapted on board to a change: {text}",
    "Identify again from a recording of the changed boat",
    words={"text": None},
)
PRIOR_DOMINATES = Spec(
    "the recording has little information on {parameters}: their values are mostly the prior's",
    "If they matter, record more, with more excitation",
    {"parameters": NAMES},
)
PRIOR_COUNTED_TWICE = Spec(
    "the prior was identified from {recordings}, too: their information counts twice",
    "Give recordings that the prior was not identified from",
    {"recordings": NAMES},
)
