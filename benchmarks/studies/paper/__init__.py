# SPDX-License-Identifier: MIT
"""The paper's findings on simulated trials: what holds, and where.

python -m benchmarks.studies.paper run --seeds 4      # takes an hour; can be stopped and continued
python -m benchmarks.studies.paper write              # the tables and maps of docs/paper.md
python -m benchmarks.studies.paper figures            # Figs. 4 to 7
"""
