# SPDX-License-Identifier: MIT
"""Findings of a validation."""

from seatrial.boat.finding_texts.spec import ONE_NAME, Spec

NO_FILTER = Spec(
    "no predictions from filtered velocities and no residuals: {reason}",
    "Use the predictions from measured velocities",
    words={"reason": None},
)
HORIZON_NOT_PREDICTED = Spec(
    "not every horizon is predicted: {reason}",
    "Use the model at the predicted horizons only",
    words={"reason": None},
)
EXCEEDS_EXPECTED_ERROR = Spec(
    "{axis}: the error {horizon:g} s ahead is {ratio:.1f} times the expected error. {cause_means}",
    "If it matters, identify again from recordings like this",
    {"axis": ONE_NAME},
    {"ratio": "-", "horizon": "s"},
    {
        "cause": {
            "pose noise": "The excess vanishes at longer horizons: pose noise differs from the model's, and "
            "the boat has not changed",
            "model mismatch": "The model was identified from this recording: model mismatch",
            "change": "Payload, wind or water changed since it was identified, or the boat is driven "
            "differently",
        }
    },
)
THROUGH_WATER = Spec(
    "velocities are relative to the water: the poses are corrected for the current of {current:.2g} m/s that "
    "was identified in this recording",
    "For velocities over ground add the current",
    numbers={"current": "m/s"},
)
SLOW_POSES = Spec(
    "poses are {period:.2g} s apart: the reference velocities miss motion that is shorter than four of them. The "
    "noise floor includes the part of this error that the model predicts",
    "Record poses at a higher rate",
    numbers={"period": "s"},
)
OTHER = Spec("{text}", "", words={"text": None})
