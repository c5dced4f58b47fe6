# SPDX-License-Identifier: MIT
"""What a terminal shows: a progress bar on one line, and text in colours."""
