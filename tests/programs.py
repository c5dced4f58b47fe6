# SPDX-License-Identifier: MIT
"""Programs in processes of their own."""

import subprocess
import sys
from functools import partial
from pathlib import Path

PROGRAM = str(Path(sys.executable).parent / "seatrial")  # as it is installed
piped = partial(subprocess.run, capture_output=True, text=True, check=False)


def printed(*command, **given) -> str:
    """What a program prints that must succeed."""
    done = piped([str(word) for word in command], **given)
    assert done.returncode == 0, f"{command}\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
    return done.stdout
