# SPDX-License-Identifier: MIT
"""The model on board: predictor (EKF), odometry in the frames of REP-105, and both without ROS."""
