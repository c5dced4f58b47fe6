# SPDX-License-Identifier: MIT
"""Models for other programs: C, MATLAB, FMI, Gazebo, CasADi, ROS, LaTeX, JSON."""

from seatrial.export.formats import FORMATS, format_of
from seatrial.export.hull import Hull
from seatrial.export.write_export import export

__all__ = ["FORMATS", "Hull", "export", "format_of"]
