# SPDX-License-Identifier: MIT
"""Boats drawn at random, none like another: whether each is found, and whether its intervals hold.

    python -m benchmarks.fleet --boats 200

Hull, thrusters and where they stand, actuator chain, unmodelled force, pose rate and pose noise are drawn
anew for each (`draw.py`). It is driven by random pulses of a joypad and identified from three recordings.
"""
