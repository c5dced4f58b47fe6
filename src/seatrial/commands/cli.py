# SPDX-License-Identifier: MIT
"""The command line. No logic: every command is the library function of the same name."""

import os
import sys
from collections.abc import Sequence
from contextlib import nullcontext, suppress

from seatrial.commands import make_parser
from seatrial.util.errors import SeatrialError
from seatrial.util.printing import STANDARD_OUTPUT, columns_of, complain, data_only, tables_fit
from seatrial.util.progress import show_progress

DONE, MISTAKE, INTERRUPTED = 0, 1, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. Returns 0 done, 1 a mistake of the user's; wrong arguments exit with 2."""
    # small matrices: the threads of BLAS only wait for each other. It reads this when numpy is imported
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _hold_streams()
    try:
        args = make_parser().parse_args(arguments)  # imports the command
        to_programs = str(getattr(args, "json", "")) == STANDARD_OUTPUT
        with (
            show_progress(quiet=args.quiet),
            tables_fit(columns_of(sys.stdout)),
            data_only() if to_programs else nullcontext(),
        ):
            args.run(args)
        if sys.stdout is not None:
            sys.stdout.flush()
    except SeatrialError as error:
        complain(str(error))
        return MISTAKE
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        pass
    except OSError as error:  # a full disk behind standard output, a folder that is gone
        complain(f"{error.filename or 'standard output'}: {error.strerror or error}")
        return MISTAKE
    finally:
        _end_streams()
    return DONE


def _hold_streams() -> None:
    """Keep the numbers of closed standard streams, so that no file that is opened gets one of them."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free


def _end_streams() -> None:
    """Write what is left in the buffers, or drop it: not when the interpreter ends, with exit code 120."""
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except (OSError, ValueError):
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


if __name__ == "__main__":
    sys.exit(main())
