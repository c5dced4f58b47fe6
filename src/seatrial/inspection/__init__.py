# SPDX-License-Identifier: MIT
"""What is in recordings and what is wrong with them; a vehicle file proposed from a recording."""
