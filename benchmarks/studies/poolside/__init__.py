# SPDX-License-Identifier: MIT
"""Minutes until a drive is enough: guided by the advice, by the paper's S1 to S3, and at random."""
