# SPDX-License-Identifier: MIT
"""The guided path from logs to a trusted model, and the next step after each command."""
