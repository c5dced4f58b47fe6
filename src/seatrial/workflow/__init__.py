# SPDX-License-Identifier: MIT
"""What a model is fit for, and the next step after each command."""
