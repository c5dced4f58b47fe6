# SPDX-License-Identifier: MIT
"""What older versions wrote into files, read as what this version writes."""
