# SPDX-License-Identifier: MIT
"""Hector mapping, the paper's SLAM, with and without the odometry node, in ROS 1.

    export SEATRIAL_HECTOR=/path/of/catkin_ws/devel       # where hector_mapping was built
    python -m benchmarks.studies.hector                   # all tables, up to half an hour on two cores
    python -m benchmarks.studies.hector hector-forced     # one
    python -m benchmarks.studies.hector --seeds 1         # of one drive
    python -m benchmarks.studies.hector --write           # into docs/slam.md, and its picture

The drives and scans are those of benchmarks.studies.slam. The odometry node's model is identified from
Hector's own poses of other drives. Simulated time waits for Hector and the node: no scan is dropped.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "tests"))  # its tools import each other by name
