# SPDX-License-Identifier: MIT
"""All that the report computes of a model and its recordings, once."""
