# SPDX-License-Identifier: MIT
"""Identification while driving: the signals' health, the model so far, what to drive next, and when to stop."""
