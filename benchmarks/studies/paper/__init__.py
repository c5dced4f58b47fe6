# SPDX-License-Identifier: MIT
"""The paper's findings, put to the test on simulated trials: what holds, and where.

python -m benchmarks.paper run --seeds 4      # takes an hour; can be taken up again
python -m benchmarks.paper write              # the tables and figures of docs/paper.md
"""
