# SPDX-License-Identifier: MIT
"""Changes of a running boat: noticed, named, sized; false alarms without one, and odometry."""
