# SPDX-License-Identifier: MIT
"""Gate: how well the estimator recovers a simulated boat, over many seeds, against Cramer-Rao bounds.

    python -m benchmarks.recovery run --seeds 200                    # adds to the file of results
    python -m benchmarks.recovery run --seeds 10 --groups moved      # docs/identify.md
    python -m benchmarks.recovery run --seeds 200 --groups terms     # docs/select.md
    python -m benchmarks.recovery tables                             # what there are results for
    python -m benchmarks.recovery write                              # into docs/recovery.md and docs/identify.md
    python -m benchmarks.recovery figure --out docs/images/noise.svg

Groups: still, pushed (unmodelled force), together (MP and AF in one fit), faults, noise, moved (a hand or
a wall moves the boat), terms (selection). `run` can be stopped and continued.
"""
