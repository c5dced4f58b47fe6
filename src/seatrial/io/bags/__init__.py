# SPDX-License-Identifier: MIT
"""Bags of ROS 1 and ROS 2: opening, reading, salvage, writing."""
