# SPDX-License-Identifier: MIT
"""SLAM with and without the predictor: lost matches, pose error, damage to the map.

    pip install 'small-gicp>=1.0'             # the scan matcher
    python -m benchmarks.studies.slam                 # all tables, twenty minutes on two cores
    python -m benchmarks.studies.slam reach           # one of gentle, aggressive, undistorted, reach
    python -m benchmarks.studies.slam --write         # into docs/slam.md, and its picture
    python -m benchmarks.studies.slam --write reach   # one

Simulated: MallARD, pushed by a force that no model knows of, in a pool with posts; a LiDAR whose
beams each have their own time; scan-to-map by small_gicp. Only the guess differs.
"""
