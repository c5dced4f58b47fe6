# SPDX-License-Identifier: MIT
"""From recordings to a model: methods, the default estimator, uncertainty, diagnostics."""
