# SPDX-License-Identifier: MIT
"""Errors of input: one line with what was found, what was expected, what to do."""

from __future__ import annotations

LONGEST_MESSAGE = 2000  # [characters]
LAYOUT = "\n\t"  # the control characters that seatrial itself prints


def printable(text: str, keep: str = LAYOUT) -> str:
    """The text without escape sequences and control characters; also without bytes that are no UTF-8."""
    return "".join(c if c.isprintable() or c in keep else "?" for c in text)


class SeatrialError(Exception):
    """Root of all errors that seatrial raises on purpose. The command line prints one line.

    Quotes from files may contain anything: the message is shown as one line of limited length.
    """

    def __init__(self, message: str) -> None:
        line = "".join(c if c.isprintable() else " " for c in message[: 2 * LONGEST_MESSAGE])
        super().__init__(line if len(line) <= LONGEST_MESSAGE else f"{line[:LONGEST_MESSAGE]} ...")


class FileError(SeatrialError):
    """A file that is missing, unreadable, or not what it claims to be."""


class VehicleError(SeatrialError):
    """A vehicle description that contradicts itself or the recording."""


class StructureError(SeatrialError):
    """A model structure that can't be read or solved."""


class RecordingError(SeatrialError):
    """A recording without the required data."""


class IdentificationError(SeatrialError):
    """Data from which the coefficients are not identifiable."""


class ModelError(SeatrialError):
    """A model that can't be used: wrong version, unknown keys, unstable."""


class DivergenceError(ModelError):
    """A model that diverges along a recording."""


class PredictorError(SeatrialError):
    """An input that does not fit the predictor's model."""


class AllocationError(SeatrialError):
    """Thrusters or a wrench without an allocation."""


class LiveError(SeatrialError):
    """An invalid line, or an endpoint that can't be opened."""


class ExportError(SeatrialError):
    """An unknown format, or one that can't represent the model."""


class ControlError(SeatrialError):
    """A controller that is not possible with this model, delay or request."""


class SimulatorError(SeatrialError):
    """A scene, a boat or a command that can't be simulated."""


class MimicError(SeatrialError):
    """A carrier that can't follow a boat."""


class FleetError(SeatrialError):
    """A fleet, or workers for it, that can't be used."""
