# SPDX-License-Identifier: MIT
"""The line of progress on a terminal: when it is there, and when it is out of the way."""

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

from seatrial.util.status import Status

if TYPE_CHECKING:
    from seatrial.util.console.progress_bar import Bar

LINE_AFTER = 0.5  # [s] work that is shorter shows no line, and does not import rich


class ProgressLine:
    """One line of a terminal, drawn again and again, also between two reports."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.begun: float | None = None  # first report: the work's imports are before it
        self.status = Status("", 0.0, None)
        self.bar: Bar | None = None  # None: not yet, or no more
        self.lock = threading.RLock()
        self.covers = 0  # how often it is hidden at the moment
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self._begin, name="progress", daemon=True)

    def __enter__(self) -> "ProgressLine":
        return self

    def __exit__(self, *_: object) -> None:
        self.ended.set()
        if self.thread.is_alive():
            self.thread.join()
        with self.lock:
            if self.bar is not None:
                self.bar.stop()
                self.bar = None

    def update(self, status: Status) -> None:
        """Show this at the next drawing."""
        self.status = status
        if self.begun is None:
            self.begun = time.monotonic()
        if not self.thread.ident and not self.ended.is_set():
            self.thread.start()

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Remove the line, and do not draw it meanwhile."""
        with self.lock:
            since, self.covers = time.monotonic(), self.covers + 1
            if self.bar is not None and self.covers == 1:
                self.bar.stop()
            try:
                yield
            finally:
                self.covers -= 1
                if self.begun is not None and self.covers == 0:  # no time of the work
                    self.begun += time.monotonic() - since
                if self.bar is not None and self.covers == 0:  # a question prints within
                    self.bar.start()

    def _begin(self) -> None:
        """Draw from now on, where the work lasts."""
        if self.ended.wait(LINE_AFTER) or os.environ.get("TERM") == "dumb":
            return
        from seatrial.util.console.progress_bar import Bar

        with self.lock:
            if not self.ended.is_set():
                self.bar = Bar(self.stream, lambda: self.status, lambda: self.begun)
                self.bar.start()
