# SPDX-License-Identifier: MIT
"""Signals among the columns of tables: by the words of their names, and by their values."""
