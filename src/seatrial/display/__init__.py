# SPDX-License-Identifier: MIT
"""How models, scores and recordings show themselves in a notebook: tables as HTML, plots with Matplotlib."""
