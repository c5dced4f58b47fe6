# SPDX-License-Identifier: MIT
"""`seatrial` in a process of its own and within limits, without the second that Python takes to start.

A program that has imported what commands import forks for each call. Of several tests in one worker, one starts it.
"""

import atexit
import json
import os
import signal
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

LONGEST = 300  # [s] on the clock: then the call is killed


@cache
def _warm() -> "subprocess.Popen[str]":
    started = subprocess.Popen(
        [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    atexit.register(started.kill)
    return started


def seatrial(*arguments: object, memory: int, seconds: int) -> tuple[int, str, str]:
    """Exit code, or minus the signal that ended it, and what it printed. `memory` [bytes] of addresses, CPU [s]."""
    with tempfile.TemporaryDirectory() as name:
        asked = {
            "arguments": [*map(str, arguments)], "memory": memory, "seconds": seconds, "folder": name,
            "at": str(Path.cwd()),
        }  # fmt: skip
        warm = _warm()
        warm.stdin.write(json.dumps(asked) + "\n")
        warm.stdin.flush()
        code = int(warm.stdout.readline())
        out, err = ((Path(name) / each).read_text() for each in ("out", "err"))
    return code, out, err


def _call(asked: dict) -> None:
    """The child: it never returns."""
    import resource

    for number, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(Path(asked["folder"]) / name, os.O_WRONLY | os.O_CREAT), number)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.chdir(asked["at"])
    signal.alarm(LONGEST)
    for kind, most in (
        (resource.RLIMIT_AS, asked["memory"]),
        (resource.RLIMIT_CPU, asked["seconds"]),
    ):
        resource.setrlimit(kind, (most, most))
    code = 1
    try:
        from seatrial.commands.cli import main

        code = main(asked["arguments"])
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:
        import traceback

        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _serve() -> None:
    import seatrial.commands.inspect
    import seatrial.io.bags.opening  # noqa: F401

    for line in sys.stdin:
        if (child := os.fork()) == 0:
            _call(json.loads(line))
        sys.stdout.write(f"{os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    _serve()
