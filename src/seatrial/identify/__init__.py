# SPDX-License-Identifier: MIT
"""From recordings to a model. One estimator a file; each has the same signature."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from seatrial.errors import IdentificationError, RecordingError
from seatrial.frames import AXES, Axes
from seatrial.identify.equation_error import METHOD, EquationErrorSettings, equation_error
from seatrial.identify.output_error import METHOD as OUTPUT_ERROR
from seatrial.identify.output_error import output_error
from seatrial.inspect import implausible
from seatrial.model import Model
from seatrial.recording import Recording
from seatrial.sanity import concerns, sanity, sanity_line
from seatrial.signs import check_signs
from seatrial.vehicle import Vehicle
from seatrial.velocity import STENCIL_NOISE

METHODS = (METHOD, OUTPUT_ERROR)
DEFAULT_METHOD = METHOD
SHORTEST = 10.0  # [s] of all recordings together

__all__ = ["DEFAULT_METHOD", "METHODS", "EquationErrorSettings", "caution", "identify", "summary"]


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
    files = [(s.path.resolve(), r.offset) for r in recordings for s in r.sources[:1]]
    if len(set(files)) != len(files):
        raise IdentificationError(f"{', '.join(names)}: one of them is given twice")
    if len(set(names)) != len(names):
        raise IdentificationError(
            f"two recordings have the same name: {', '.join(names)}; rename one"
        )
    length = sum(r.duration for r in recordings)
    if length < SHORTEST:
        raise IdentificationError(
            f"{', '.join(names)}: {length:.1f} s in all is too short; drive a minute or more in "
            "every axis"
        )
    for recording in recordings:
        for sentence in implausible(recording):
            raise RecordingError(f"{recording.name}: {sentence}")
    if method == OUTPUT_ERROR:
        if settings is not None and settings.literal:
            raise IdentificationError(f"Eq. (17) as printed belongs to {METHOD}, not to {method}")
        model = output_error(recordings, vehicle, roles=roles)
    else:
        model = equation_error(recordings, vehicle, roles=roles, settings=settings)
    sanity(model)
    wrong = [finding.text for finding in check_signs(recordings, vehicle).findings]
    return replace(model, warnings=(*wrong, *concerns(model)))


def caution(model: Model) -> str:
    """What the paper's method leaves out of its standard errors, with this recording's noise."""
    spread = STENCIL_NOISE / model.integration.step
    noise = model.noise
    return (
        f"± covers scatter only. {1e3 * noise.position:.2g} mm and {1e3 * noise.heading:.2g} mrad of "
        f"pose noise are {100 * spread * noise.position:.2g} cm/s and {spread * noise.heading:.2g} "
        "rad/s in the differentiated velocities; that biases this method, drag most of all."
    )


def summary(model: Model) -> str:
    """Coefficients, warnings and what they mean for the boat, for the terminal."""
    units = model.structure.units
    lines = [
        f"  {name:<6} {_digits(value, model.standard_errors[name])}  {units[name]}"
        for name, value in model.values.items()
    ]
    lines += [f"  doubt: {warning}" for warning in model.warnings]
    lines += [caution(model)] if model.estimator.method == METHOD else []
    head = f"{model.name}, {model.estimator.method}, in {Axes.FLU.value} axes"
    head += f"; {_roles_said(model)}:" if model.estimator.steps else ":"
    flipped = [n for n in model.values if n in model.structure.flipped_coefficients]
    if model.vehicle.axes is not Axes.FLU and flipped:
        lines.append(
            f"The file is in {model.vehicle.axes.value} axes: {', '.join(flipped)} negated."
        )
    return "\n".join([head, *lines, sanity_line(model)])


def _digits(value: float, error: float) -> str:
    """A coefficient and its standard error with as many digits as they need."""
    small = 0.0 < max(abs(value), error) < 0.01
    return f"{value:10.3e} ± {error:.1e}" if small else f"{value:10.4f} ± {error:.4f}"


def _roles_said(model: Model) -> str:
    """Which recordings identified which axis."""
    parts = {
        axis: ", ".join(step.recordings)
        for axis, step in zip(AXES, model.estimator.steps, strict=False)
    }
    if len(set(parts.values())) == 1:
        return f"all from {next(iter(parts.values()))}"
    return ", ".join(f"{axis} from {names}" for axis, names in parts.items())
