# SPDX-License-Identifier: MIT
"""A figure's SVG as PNG, with a font of its own: the same on every machine. Needs resvg-py."""

from importlib import resources
from importlib.util import find_spec

from seatrial.util.errors import FileError

SCALE = 3.0  # of the SVG's pixels: 1920 across, 300 dots an inch at 16 cm
FAMILY = "DejaVu Sans"  # of the file below; letters that it lacks come from the system's fonts
FONT = "dejavu-sans.ttf"


def check() -> None:
    """Raise FileError where the package that draws PNG is not installed."""
    if find_spec("resvg_py") is None:
        raise FileError("PNG needs resvg-py: pip install 'seatrial[png]'")


def png(svg: str) -> bytes:
    """The figure on white, as a PNG file's content; FileError as in `check`."""
    check()
    import resvg_py  # noqa: PLC0415 - an extra

    with resources.as_file(resources.files("seatrial.report") / "assets" / FONT) as font:
        return bytes(
            resvg_py.svg_to_bytes(
                svg_string=svg, zoom=SCALE, background="white", font_files=[str(font)],
                font_family=FAMILY, sans_serif_family=FAMILY,
            )
        )  # fmt: skip
