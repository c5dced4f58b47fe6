# SPDX-License-Identifier: MIT
"""From a log to a trusted model: what a model is fit for, what to do next."""
