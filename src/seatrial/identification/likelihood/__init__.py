# SPDX-License-Identifier: MIT
"""The prediction-error likelihood: problem, noise structures, fit horizon, optimiser."""
