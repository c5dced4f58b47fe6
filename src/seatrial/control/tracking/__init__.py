# SPDX-License-Identifier: MIT
"""The tracking controller and its reference courses."""
