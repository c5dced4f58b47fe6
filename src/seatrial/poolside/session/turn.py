# SPDX-License-Identifier: MIT
"""When work of a session is due again, so that it leaves the core to others."""

import time

LATE = 1.0  # [s] by which this computer falls behind, that is reported
IDLE = 4.0  # times the duration of the last one, at least: a fifth of a core


class Turn:
    """When work is due again: after `least` [s], and after `IDLE` times its own duration."""

    def __init__(self, least: float) -> None:
        self._least, self._begun, self._next = least, 0.0, 0.0

    @property
    def due(self) -> bool:
        """Whether it is."""
        return time.monotonic() >= self._next

    def __enter__(self) -> None:
        self._begun = time.monotonic()

    def __exit__(self, *_: object) -> None:
        now = time.monotonic()
        self._next = now + max(self._least, IDLE * (now - self._begun))


def slow_text(late: float) -> str:
    """That this computer falls behind by `late` [s]; empty where it does not."""
    if late < LATE:
        return ""
    return (
        f"this computer is {late:.1f} s behind what arrives; no row is lost. Close other programs, or send "
        "fewer rows a second"
    )
