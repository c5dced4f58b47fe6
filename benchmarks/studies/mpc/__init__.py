# SPDX-License-Identifier: MIT
"""Model predictive control in closed loop, against the tuned PID on the same courses.

python -m benchmarks.studies.mpc             # all tables
python -m benchmarks.studies.mpc walls       # one
python -m benchmarks.studies.mpc --write     # into docs/mpc.md, with its picture
"""
