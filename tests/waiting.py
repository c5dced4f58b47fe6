# SPDX-License-Identifier: MIT
"""Waiting for another process, thread or clock: for what is to happen, never for a time in which it should have."""

import os
import random
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

# [s] a machine that tests other things beside is slow, or stands still for a while
PATIENCE = 120.0
AHEAD = -5  # priority (nice) of a program that keeps real time, before tests that compute beside it
PORTS = (20_000, 32_000)  # below those that Linux hands out by itself


def until(true: Callable[[], Any], what: object = "", patience: float = PATIENCE) -> Any:
    """Its value, once it is true. Fails after `patience` [s]; `what` says what was waited for, or shows it."""
    end = time.monotonic() + patience
    while not (found := true()):
        assert time.monotonic() < end, what() if callable(what) else what
        time.sleep(0.02)
    return found


def go_ahead(process: int) -> None:
    """Let a program that keeps real time run before others, where the system allows it (root)."""
    with suppress(PermissionError, ProcessLookupError):
        os.setpriority(os.PRIO_PROCESS, process, AHEAD)


def free_port() -> int:
    """A port of loopback that nobody has, for a program that is about to take it: no other gets it by chance."""
    while True:
        port = random.SystemRandom().randrange(*PORTS)
        with socket.socket() as stream, socket.socket(type=socket.SOCK_DGRAM) as datagrams:
            try:
                stream.bind(("127.0.0.1", port))
                datagrams.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
