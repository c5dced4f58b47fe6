# SPDX-License-Identifier: MIT
"""Mistakes of the user's: one line that says what was got, what was expected, what to do."""


class SeatrialError(Exception):
    """Root of all errors that seatrial raises on purpose. The command line prints one line."""


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
