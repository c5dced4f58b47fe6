# SPDX-License-Identifier: MIT
"""The report's plots as plain Plotly figures; `report.js` and `svg.py` draw them."""
