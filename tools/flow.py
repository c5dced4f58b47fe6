# SPDX-License-Identifier: MIT
"""Draw docs/images/flow.svg: from a log to a model, and what the model is for. Light and dark.

python tools/flow.py
"""

from dataclasses import dataclass
from html import escape
from pathlib import Path

OUT = Path(__file__).resolve().parents[1] / "docs" / "images" / "flow.svg"
TITLE = "From a log to a model, and what the model is for"
WIDTH, MARGIN, GAP = 920, 16, 30  # [px] of the picture, at its edge, between boxes
HEAD, LINE, END = 26, 19, 12  # [px] from a box's top to its heading, to each further line, below
BETWEEN = 62  # [px] between both rows
BAND = 34  # [px] above the steps of `auto`, for its name
STYLE = """
  text { font-family: Helvetica, Arial, 'Liberation Sans', sans-serif; text-anchor: middle; fill: #1d2a35 }
  .ground { fill: #ffffff } .line { fill: none; stroke: #4a5a68; stroke-width: 1.6 } .tip { fill: #4a5a68 }
  .log, .step { fill: #eef2f5; stroke: #8a9aa8 } .model { fill: #dcebf7; stroke: #0072b2 }
  .use { fill: #fdf1dd; stroke: #c98500 } .band { fill: none; stroke: #0072b2; stroke-dasharray: 5 4 }
  .head { font-size: 15px; font-weight: bold } .small { font-size: 13px }
  @media (prefers-color-scheme: dark) {
    text { fill: #e8eaed } .ground { fill: #14171a } .line { stroke: #a3abb3 } .tip { fill: #a3abb3 }
    .log, .step { fill: #262b31; stroke: #6c7782 } .model { fill: #12344d; stroke: #56b4e9 }
    .use { fill: #3d3012; stroke: #e0a83c } .band { stroke: #56b4e9 }
  }
"""


@dataclass(frozen=True)
class Box:
    """A step: its kind (colour), heading and lines."""

    kind: str
    head: str
    text: str  # lines, divided by |


STEPS = (
    Box("log", "log", "poses and commands:|bag, .BIN, .ulg, .tlog, CSV;|some minutes of driving"),
    Box("step", "init, inspect", "vehicle.yaml: signals,|axes, thrusters; faults,|clocks, signs"),
    Box(
        "model",
        "identify, select",
        "model.yaml: hull, thrusters,|noise, each number with|its standard error",
    ),
    Box(
        "step",
        "validate, report",
        "error on a part held out;|fit for use or not;|what to drive next",
    ),
)
USES = (
    Box(
        "use",
        "on board: predict",
        "velocity and odometry|between poses, for SLAM:|Python, C++, ROS 1 and 2",
    ),
    Box(
        "use",
        "control: tune, allocate",
        "tracking controller, MPC,|thrust allocation outside|the dead zones",
    ),
    Box(
        "use",
        "simulate, sim, mimic",
        "trials, a live boat with|SLAM, IMU and LiDAR, a|robot that moves like it",
    ),
    Box(
        "use", "export, compare", "C99, MATLAB, Octave, FMI,|CasADi, Gazebo; what a|payload changed"
    ),
)


def drawn() -> str:
    """The picture as text."""
    width = (WIDTH - 2 * MARGIN - 3 * GAP) / 4
    lefts = [MARGIN + i * (width + GAP) for i in range(4)]
    high = HEAD + 3 * LINE + END + 6
    top, below = MARGIN + BAND, MARGIN + BAND + high + BETWEEN
    height = below + high + MARGIN
    middle = [left + width / 2 for left in lefts]
    fork = top + high + BETWEEN / 2 + 4
    arrows = [f"M{left + width:g} {top + high / 2:g} h{GAP - 3}" for left in lefts[:3]]
    arrows += [f"M{middle[2]:g} {top + high:g} V{fork:g} H{x:g} V{below - 2:g}" for x in middle]
    band = (
        lefts[1] - GAP / 3,
        MARGIN,
        WIDTH - MARGIN - lefts[1] + 2 * GAP / 3 - 4,
        high + BAND + 12,
    )
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" '
        'aria-labelledby="title">',
        f'<title id="title">{TITLE}</title>',
        f"<style>{STYLE}</style>",
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" '
        'orient="auto"><path class="tip" d="M0 0 L8 4 L0 8 z"/></marker></defs>',
        f'<rect class="ground" width="{WIDTH}" height="{height}" rx="8"/>',
        '<rect class="band" x="{:g}" y="{:g}" width="{:g}" height="{:g}" rx="8"/>'.format(*band),
        f'<text class="head" x="{middle[2]:g}" y="{MARGIN + 22}">seatrial auto LOG: one command</text>',
        *(f'<path class="line" d="{path}" marker-end="url(#tip)"/>' for path in arrows),
        *(_box(box, left, top, width, high) for box, left in zip(STEPS, lefts, strict=True)),
        *(_box(box, left, below, width, high) for box, left in zip(USES, lefts, strict=True)),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _box(box: Box, left: float, top: float, width: float, high: float) -> str:
    """A box with its heading and lines."""
    x = left + width / 2
    lines = [
        f'<rect class="{box.kind}" x="{left:g}" y="{top:g}" width="{width:g}" height="{high:g}" rx="6"/>',
        f'<text class="head" x="{x:g}" y="{top + HEAD:g}">{escape(box.head)}</text>',
    ]
    lines += [
        f'<text class="small" x="{x:g}" y="{top + HEAD + 6 + LINE * (i + 1):g}">{escape(text)}</text>'
        for i, text in enumerate(box.text.split("|"))
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    OUT.write_text(drawn(), "utf-8")
