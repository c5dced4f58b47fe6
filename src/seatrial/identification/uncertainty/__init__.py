# SPDX-License-Identifier: MIT
"""How well parameters are known: covariance, profiles, bootstrap, record length."""
