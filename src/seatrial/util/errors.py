# SPDX-License-Identifier: MIT
"""Mistakes of the user's: one line that says what was got, what was expected, what to do."""

LONGEST = 2000  # [characters] of a line


class SeatrialError(Exception):
    """Root of all errors that seatrial raises on purpose. The command line prints one line.

    What it quotes out of files may hold anything: it is shown as one line, and not a long one.
    """

    def __init__(self, message: str) -> None:
        line = "".join(c if c.isprintable() else " " for c in message[: 2 * LONGEST])
        super().__init__(line if len(line) <= LONGEST else f"{line[:LONGEST]} ...")


class FileError(SeatrialError):
    """A file that is missing, unreadable, or not what it claims to be."""


class VehicleError(SeatrialError):
    """A vehicle description that contradicts itself or the recording."""


class StructureError(SeatrialError):
    """A model structure that can't be read or solved."""


class RecordingError(SeatrialError):
    """A recording that lacks what is asked of it."""


class IdentificationError(SeatrialError):
    """Data from which the coefficients can't be told."""


class ModelError(SeatrialError):
    """A model that can't be used: wrong version, unknown keys, unstable."""


class PredictorError(SeatrialError):
    """An input that does not fit the predictor's model."""


class AllocationError(SeatrialError):
    """Thrusters, or a wrench, that nothing can be allocated to."""


class LiveError(SeatrialError):
    """A line that can't be used, or a place where none can be read or written."""


class ExportError(SeatrialError):
    """A format that there is not, or that can't say what the model says."""


class ControlError(SeatrialError):
    """A controller that the model, its delay or the request does not permit."""


class SimulatorError(SeatrialError):
    """A scene, a boat or a command that can't be simulated."""


class MimicError(SeatrialError):
    """A carrier that can't follow a boat."""
