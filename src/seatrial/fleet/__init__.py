# SPDX-License-Identifier: MIT
"""Many boats and recordings at once: each identified and validated, all in one table and one report."""
