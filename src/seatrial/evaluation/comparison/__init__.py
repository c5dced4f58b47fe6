# SPDX-License-Identifier: MIT
"""Comparison of two models of a boat: parameters, physics, prediction."""
