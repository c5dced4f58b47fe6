# SPDX-License-Identifier: MIT
"""Tests of a running boat against its model."""
