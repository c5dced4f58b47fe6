# SPDX-License-Identifier: MIT
"""What stands in a file: which YAML, and what is wrong with its content, in plain words."""
