# SPDX-License-Identifier: MIT
"""How many of the 95 % intervals at the verdict hold the truth: guided drives, up to "enough".

    python -m benchmarks.studies.poolside.coverage --seeds 12

A drive ends where its own intervals are narrow enough. This shows whether that makes them too narrow.
"""

import sys
from collections.abc import Sequence

import numpy as np

from benchmarks.studies.poolside.__main__ import by_water, of_waters, spelled
from benchmarks.studies.poolside.drivers import Guided
from benchmarks.studies.poolside.drives import LONGEST, WATERS, Drive, Outcome


def outcome(water: str, seed: int) -> Outcome:
    """A guided drive up to its verdict."""
    own = WATERS[water](seed)
    return Drive(own, Guided(own, seed)).run(LONGEST, {}, verdict=True)


def main(arguments: Sequence[str]) -> None:
    """Print a line a boat."""
    given = of_waters("studies.poolside.coverage", __doc__, 12).parse_args(arguments)
    for water, found in by_water(given, outcome):
        held = np.concatenate([one.inside for one in found])
        missed = [len(one.inside) - sum(one.inside) for one in found]
        minutes = spelled([one.enough for one in found])
        print(
            f"{WATERS[water].name}: {len(found)} drives, {minutes} min to enough; {100 * held.mean():.1f} % of "
            f"{len(held)} intervals hold the truth; most missed in one drive: {max(missed)}"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
