# SPDX-License-Identifier: MIT
"""Model predictive control in closed loop, against the tuned PID on the same courses."""
