# SPDX-License-Identifier: MIT
"""How far a model can be trusted: prediction errors, filtering, validation, comparison of models."""
