# SPDX-License-Identifier: MIT
"""The same estimation as one would write it with CasADi, SciPy or JAX. One file each."""
