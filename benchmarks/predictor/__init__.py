# SPDX-License-Identifier: MIT
"""Gate: accuracy, consistency and speed of the on-board predictor.

    python -m benchmarks.predictor                 # all tables but the soak
    python -m benchmarks.predictor velocity speed  # some
    python -m benchmarks.predictor --soak          # and 10^7 steps, some minutes
    python -m benchmarks.predictor --write         # all into docs/onboard.md
    python -m benchmarks.predictor --write speed   # some

Simulated: S1-S3 of the preset `hard` (4 mm, 4 mrad, 15 Hz, drop-outs, two clocks) to identify from,
S7 to drive along, "pushed" with an unmodelled force of 4 % of full thrust that lasts 2 s. Poses
are those of the SLAM. Real: CSE1, the run that the model was not identified from.
"""
