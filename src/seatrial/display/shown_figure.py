# SPDX-License-Identifier: MIT
"""A figure that a notebook shows once. One of pyplot's is shown twice where a cell ends with it."""

from io import BytesIO

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure without pyplot: nothing keeps it, no window shows it."""

    def _repr_png_(self) -> bytes:
        out = BytesIO()
        self.savefig(out, format="png")
        return out.getvalue()
