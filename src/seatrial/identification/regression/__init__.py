# SPDX-License-Identifier: MIT
"""Regressions on accelerations or on their weak form: other methods, and start values."""
