# SPDX-License-Identifier: MIT
"""The page of a session at the poolside, and its server."""
