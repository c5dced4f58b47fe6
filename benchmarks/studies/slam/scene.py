# SPDX-License-Identifier: MIT
"""The pool with posts and boxes."""

import numpy as np

from seatrial.simulation.plan import Pool
from seatrial.simulation.scene import Scene, box

POOL = Pool(length=12.0, width=5.0, margin=0.5)


def pool_scene() -> Scene:
    """Walls, two posts and a box along the middle, a box and a ladder at the walls."""
    return Scene(
        np.vstack([
            box(0.0, 0.0, POOL.length, POOL.width),
            box(2.4, -0.1, 0.5, 0.4, turn=0.4),
            box(-4.6, 2.2, 0.8, 0.6),
            box(3.6, -2.4, 0.5, 0.2),
        ]),
        np.array([[0.0, 0.1, 0.15], [-2.6, -0.2, 0.1]]),
    )  # fmt: skip
