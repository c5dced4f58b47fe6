# SPDX-License-Identifier: MIT
"""Studies behind pages of docs/: run when their subject changes, not with every commit."""
