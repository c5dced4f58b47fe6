# SPDX-License-Identifier: MIT
"""Recordings in memory: signals and their timing, pose faults, velocity, pose noise, excitation."""
