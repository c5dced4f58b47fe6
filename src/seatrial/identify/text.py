# SPDX-License-Identifier: MIT
"""What was found, for the terminal: a screenful."""

from seatrial.frames import AXES, Axes
from seatrial.identify.equation_error import METHOD
from seatrial.model import Model
from seatrial.sanity import sanity_line
from seatrial.velocity import STENCIL_NOISE


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
