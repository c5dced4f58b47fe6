# SPDX-License-Identifier: MIT
"""Gates and studies on one harness; README.md names the figure that each of them guards."""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy; worker processes inherit it
