# SPDX-License-Identifier: MIT
"""Sentences and advice of findings, by subject; `FindingKind` lists the kinds."""
