# SPDX-License-Identifier: MIT
"""From recordings to a model. One estimator a file; each has the same signature."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from seatrial.errors import IdentificationError
from seatrial.identify.equation_error import EquationErrorSettings, equation_error
from seatrial.model import Model
from seatrial.recording import Recording
from seatrial.sanity import doubts, sanity, sanity_line
from seatrial.vehicle import Vehicle

METHODS = ("equation-error",)
DEFAULT_METHOD = "equation-error"

__all__ = ["DEFAULT_METHOD", "METHODS", "EquationErrorSettings", "identify", "summary"]


def identify(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    method: str = DEFAULT_METHOD,
    roles: Mapping[str, Sequence[str]] | None = None,
    settings: EquationErrorSettings | None = None,
) -> Model:
    """The vehicle's model from its recordings, checked for physical sense.

    `roles` names the recordings that identify surge, sway and yaw; by default they are found from
    the excitation. Raises IdentificationError, RecordingError, ModelError (unstable).
    """
    if method not in METHODS:
        raise IdentificationError(f"no method '{method}'; there are {', '.join(METHODS)}")
    if not recordings:
        raise IdentificationError("no recording given; pass at least one")
    names = [r.name for r in recordings]
    if len(set(names)) != len(names):
        raise IdentificationError(
            f"two recordings have the same name: {', '.join(names)}; rename one"
        )
    model = equation_error(recordings, vehicle, roles=roles, settings=settings)
    sanity(model)
    return replace(model, warnings=(*model.warnings, *doubts(model)))


def summary(model: Model) -> str:
    """Coefficients, warnings and what they mean for the boat, for the terminal."""
    units = model.structure.units
    lines = [
        f"  {name:<6} {value:10.4f} ± {model.standard_errors[name]:.4f}  {units[name]}"
        for name, value in model.values.items()
    ]
    lines += [f"  doubt: {warning}" for warning in model.warnings]
    return "\n".join([f"{model.name}, {model.estimator.method}:", *lines, sanity_line(model)])
