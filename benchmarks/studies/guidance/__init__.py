# SPDX-License-Identifier: MIT
"""A boat with two fixed thrusters in closed loop: tuned guidance against a PID with plain line of sight.

python -m benchmarks.studies.guidance             # all tables
python -m benchmarks.studies.guidance courses     # one
python -m benchmarks.studies.guidance --write     # into docs/tune.md
"""
