# SPDX-License-Identifier: MIT
"""Schemes of thrust allocation along recorded drives, and what the allocator costs on board.

python -m benchmarks.studies.allocation                # all tables
python -m benchmarks.studies.allocation mallard speed  # some
python -m benchmarks.studies.allocation --write        # all into docs/allocate.md
"""
