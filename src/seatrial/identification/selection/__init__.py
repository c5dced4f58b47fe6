# SPDX-License-Identifier: MIT
"""Which parameters are free: stages of the actuator chain, and terms of the structure."""
