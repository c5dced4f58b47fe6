# SPDX-License-Identifier: MIT
"""A whole model as JSON: parameters to run it, and the uncertainty of each."""

from typing import Any

import msgspec

from seatrial.export.content import Content
from seatrial.util.files import dump_json
from seatrial.util.frames import AXES
from seatrial.util.statistics import NORMAL_95

FORMAT = "boat 1"


def text(content: Content) -> str:
    """The file. Values are in the axes that it states; null: no such number or stage."""
    model = content.model
    return dump_json({
        "seatrial": FORMAT,
        "written_by": content.source,
        "name": model.name,
        "axes": content.axes.value,
        "integration": {"scheme": "runge-kutta", "longest_step": content.longest_step},
        "inputs": content.inputs,
        "scales": content.scales,
        "allocation": {
            "scheme": content.scheme.value,
            "inverse": content.inverse.tolist(),
            "offset": content.offset,
            "limit": content.limit,
        },
        "actuators": [_actuator(content, k) for k in range(len(content.actuators))],
        "table": content.table,
        "forces": [{"name": f.name, "axis": AXES[f.axis]} for f in content.structure.forces],
        "mix": content.mix.tolist(),
        "deflection": content.deflection.tolist(),
        "terms": _terms(content),
        "parameters": {name: _parameter(content, name) for name in content.values},
        "covariance": content.covariance.tolist(),
        "pose_noise": msgspec.to_builtins(model.noise),
        "estimator": msgspec.to_builtins(model.estimator),
        "recordings": msgspec.to_builtins(model.recordings),
        "warnings": model.warnings,
    })  # fmt: skip


def _parameter(content: Content, name: str) -> dict[str, Any]:
    """Value, unit, standard error and 95 % interval; the last two are null for a given value."""
    value, error = content.values[name], content.errors[name]
    width = NORMAL_95 * error
    return {
        "value": value,
        "unit": content.units[name],
        "standard_error": error or None,
        "interval_95": [value - width, value + width] if error > 0 else None,
        "of": "boat" if name in content.structure.coefficients else "actuators",
    }


def _terms(content: Content) -> list[dict[str, Any]]:
    """The right-hand side: number * coefficient * factors [* acceleration], for each axis summed."""
    return [
        {
            "axis": AXES[t.axis],
            "number": t.number,
            "coefficient": t.coefficient,
            "factors": t.factors,
            "acceleration": None if t.acceleration is None else AXES[t.acceleration],
        }
        for t in content.structure.terms
    ]


def _actuator(content: Content, k: int) -> dict[str, Any]:
    """Stages by the names of their constants, and the pair, with the partner by its name."""
    own = content.actuators[k]
    pair = None
    if own.partner is not None:
        partner = content.actuators[own.partner].name
        pair = {"partner": partner, "across": own.across, "mirrored": own.mirrored}
    scale = None if own.scale is None else list(content.scales)[own.scale]
    return {
        "name": own.name,
        "constants": own.constants,
        "tabulated": own.tabulated,
        "scale": scale,
        "pair": pair,
        "steers": None if own.steers is None else content.actuators[own.steers].name,
    }
