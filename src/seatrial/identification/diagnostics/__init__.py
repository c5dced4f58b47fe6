# SPDX-License-Identifier: MIT
"""What the residuals reveal: drift, homogeneity, disturbances, unmodelled effects."""
