# SPDX-License-Identifier: MIT
"""What every room uses: errors, files, frames, statistics, threads, progress, formats."""
