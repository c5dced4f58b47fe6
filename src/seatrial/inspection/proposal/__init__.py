# SPDX-License-Identifier: MIT
"""A vehicle file to start from, proposed from recordings."""
