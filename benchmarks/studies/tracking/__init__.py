# SPDX-License-Identifier: MIT
"""Tracking in closed loop: the tuned controller against PDs tuned by hand, in the simulator.

python -m benchmarks.studies.tracking             # all tables
python -m benchmarks.studies.tracking knobs       # one
python -m benchmarks.studies.tracking --write     # into docs/tune.md
"""
