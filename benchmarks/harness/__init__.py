# SPDX-License-Identifier: MIT
"""What all benchmarks share: command line, workers, stored results, tables, pages, pictures."""
