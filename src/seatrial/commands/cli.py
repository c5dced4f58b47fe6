# SPDX-License-Identifier: MIT
"""The command line. No logic: every command is the library function of the same name."""

import os
import sys
from collections.abc import Sequence

from seatrial.commands import make_parser
from seatrial.util.errors import SeatrialError
from seatrial.util.progress import show_progress

DONE, MISTAKE = 0, 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. Returns 0 done, 1 a mistake of the user's; wrong arguments exit with 2."""
    # small matrices: the threads of BLAS only wait for each other. It reads this when numpy is imported
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    args = make_parser().parse_args(arguments)
    try:
        with show_progress(quiet=args.quiet):
            args.run(args)
    except SeatrialError as error:
        print(f"seatrial: {' '.join(str(error).split())}", file=sys.stderr)
        return MISTAKE
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return DONE


if __name__ == "__main__":
    sys.exit(main())
