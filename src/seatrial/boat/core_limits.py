# SPDX-License-Identifier: MIT
"""What the core's actuator chain can hold: checked when a vehicle is built."""

from seatrial import _core
from seatrial.boat.allocation import Scheme
from seatrial.util.errors import VehicleError


def check_sizes(inputs: int, actuators: int, scales: int, constants: int, source: str) -> None:
    """Raise VehicleError where there are more of them than the core has room for."""
    if max(inputs, actuators) > _core.MAX_ACTUATORS:
        raise VehicleError(
            f"{source}: {inputs} inputs and {actuators} actuators; at most "
            f"{_core.MAX_ACTUATORS} of each"
        )
    for what, count, most in (
        ("scales", scales, _core.MAX_SCALES),
        ("constants of the chain", constants, _core.MAX_CONSTANTS),
    ):
        if count > most:
            raise VehicleError(f"{source}: {count} {what}; at most {most}")


def check_offset(scheme: Scheme, offset: float, limit: float | None, source: str) -> None:
    """Raise VehicleError where the offset of always-forward is at the limit of the commands, or above."""
    if scheme is Scheme.AF and limit is not None and offset >= limit:
        raise VehicleError(f"{source}: F_os {offset:g} leaves no room under the limit {limit:g}")
