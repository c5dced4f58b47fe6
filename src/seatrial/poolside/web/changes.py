# SPDX-License-Identifier: MIT
"""The state as JSON, and what of it changed since the last message to a page."""

import msgspec

from seatrial.poolside.state import Controller, LiveState
from seatrial.util.files import builtin

FIELDS = LiveState.__struct_fields__
Rows = list[tuple[float, float, float, float]]


encode = msgspec.json.Encoder(enc_hook=builtin).encode


class Message(msgspec.Struct, frozen=True, omit_defaults=True):
    """A message to a page: fields of `LiveState` that changed, and rows of the track from `since`."""

    state: dict[str, msgspec.Raw] = {}
    since: int = 0
    track: Rows = []


class Changes:
    """Of one page."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._sent: LiveState | None = None
        self._since = 0

    def take(self) -> str | None:
        """The next message as JSON; None where nothing changed."""
        state = self._controller.state()
        if self._sent is not None and state.discards != self._sent.discards:
            self._since = 0
        following, rows = self._controller.track(self._since)
        changed = _changed(self._sent, state)
        if not changed and not rows:
            return None
        message = Message(changed, self._since, rows)
        self._sent, self._since = state, following
        return encode(message).decode()


def _changed(sent: LiveState | None, state: LiveState) -> dict[str, msgspec.Raw]:
    """Fields that differ. A tuple that is the same object is not compared by value."""
    if sent is state:
        return {}
    pairs = ((name, getattr(state, name)) for name in FIELDS)
    return {
        name: msgspec.Raw(encode(value))
        for name, value in pairs
        if sent is None or not _same(value, getattr(sent, name))
    }


def _same(one: object, other: object) -> bool:
    return one is other or one == other
