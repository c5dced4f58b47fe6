# SPDX-License-Identifier: MIT
"""Schemes of thrust allocation along recorded drives, and what the allocator costs on board.

python -m benchmarks.allocation                # all tables
python -m benchmarks.allocation mallard speed  # some
python -m benchmarks.allocation --write        # all into docs/allocate.md
"""
