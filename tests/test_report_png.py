# SPDX-License-Identifier: MIT
"""Figures as PNG: as large as promised, on white, with letters that need no font of the machine."""

import re
import struct
import zlib
from importlib import resources

import numpy as np
import pytest

from seatrial.report import write_report
from seatrial.report.figures import png as drawing
from seatrial.report.figures.base import figure, line
from seatrial.report.figures.png import SCALE, png
from seatrial.report.figures.svg import HEIGHT, WIDTH, svg
from seatrial.util.errors import FileError

resvg_py = pytest.importorskip("resvg_py")


@pytest.fixture(scope="module")
def drawn() -> str:
    x = np.linspace(0.0, 1.0, 50)
    return svg(figure([line("üαЖ", x, x**2, "#0072b2")] * 2, "time [s]", "N<sub>rr</sub> [1/rad]"))


def pixels(content: bytes) -> np.ndarray:
    """(height, width, 4) of an 8-bit PNG with colours and opacity, its rows undone by their filters."""
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    at, data, head = 8, b"", b""
    while at < len(content):
        size, kind = struct.unpack(">I4s", content[at : at + 8])
        part = content[at + 8 : at + 8 + size]
        head, data = (part if kind == b"IHDR" else head), data + (part if kind == b"IDAT" else b"")
        at += 12 + size
    width, height, depth, colour = struct.unpack(">IIBB", head[:10])
    assert (depth, colour) == (8, 6)
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + 4 * width)
    out = np.zeros((height, width, 4), np.uint8)
    for i, row in enumerate(rows):
        own, above = row[1:].reshape(width, 4), out[i - 1] if i else np.zeros((width, 4), np.uint8)
        if row[0] == 0:
            out[i] = own
        elif row[0] == 1:
            out[i] = np.cumsum(own, axis=0, dtype=np.uint8)
        elif row[0] == 2:
            out[i] = own + above
        else:
            last, corner = np.zeros(4, int), np.zeros(4, int)
            for k in range(width):
                up = above[k].astype(int)
                if row[0] == 3:
                    guess = (last + up) // 2
                else:
                    p = last + up - corner
                    far = np.abs([p - last, p - up, p - corner])
                    guess = np.choose(far.argmin(axis=0), [last, up, corner])
                out[i, k] = own[k] + guess
                last, corner = out[i, k].astype(int), up
    return out


def test_a_figure_is_large(drawn):
    size = struct.unpack(">II", png(drawn)[16:24])
    assert size == (SCALE * WIDTH, SCALE * HEIGHT) == (1920, 1260)


def test_a_figure_is_on_white_in_its_colours(drawn, monkeypatch):
    monkeypatch.setattr(drawing, "SCALE", 0.5)
    shown = pixels(png(drawn))
    assert shown.shape == (HEIGHT / 2, WIDTH / 2, 4)
    assert (shown[..., 3] == 255).all()
    assert (shown[[0, 0, -1, -1], [0, -1, 0, -1]] == 255).all()
    assert np.mean((shown[..., :3] > 240).all(axis=2)) > 0.9
    blue = shown[..., 2].astype(int) - shown[..., 0]
    assert (blue > 60).sum() > 200  # [px] of the line
    mute = pixels(png(re.sub(r"<text.*?</text>", "", drawn)))
    dark = [int((one[..., :3] < 160).all(axis=2).sum()) for one in (mute, shown)]
    assert dark[1] > dark[0] + 100  # [px] of letters


def test_letters_come_from_the_own_font(drawn):
    with resources.as_file(resources.files("seatrial.report") / "assets" / drawing.FONT) as font:
        alone = resvg_py.svg_to_bytes(
            svg_string=drawn, zoom=SCALE, font_files=[str(font)], skip_system_fonts=True
        )
    assert bytes(alone) == png(drawn)


def test_without_the_package_it_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr(drawing, "find_spec", lambda name: None)
    with pytest.raises(FileError, match=r"pip install 'seatrial\[png\]'"):
        png("<svg/>")
    with pytest.raises(FileError, match="resvg-py"):  # before anything is computed
        write_report(None, [], tmp_path / "r.html", figures=tmp_path, raster=True)
    assert not list(tmp_path.iterdir())
