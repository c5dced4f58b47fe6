# SPDX-License-Identifier: MIT
"""What the launch files of seatrial_odometry share."""
