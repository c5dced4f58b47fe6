# SPDX-License-Identifier: MIT
"""Text, numbers, equations and tables as HTML, MathML, LaTeX and CSV."""
