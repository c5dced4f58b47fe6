# SPDX-License-Identifier: MIT
"""Readers of tables, one file a format, behind `Table`."""
