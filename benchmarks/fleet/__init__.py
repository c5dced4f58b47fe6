# SPDX-License-Identifier: MIT
"""Gate: boats drawn at random: whether each is identified, and whether its intervals hold the truth.

    python -m benchmarks.fleet --boats 200

Hull, thrusters and where they stand, actuator chain, unmodelled force, pose rate and pose noise are drawn
for each (`draw.py`). It is driven by random pulses of a joypad and identified from three recordings.
"""
