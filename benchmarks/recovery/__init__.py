# SPDX-License-Identifier: MIT
"""How well the boat comes back from simulated trials: over many seeds, against the bounds.

    python -m benchmarks.recovery run --seeds 200
    python -m benchmarks.recovery tables
    python -m benchmarks.recovery figure --out docs/images/noise.svg

`run` adds to a file of results, one line a scene and seed, and can be stopped and gone on with.
"""
