# SPDX-License-Identifier: MIT
"""Lists as one says them."""

from collections.abc import Sequence


def joined(words: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def shortened(words: Sequence[str]) -> str:
    """The same; of more than four the first two, and how many more."""
    return joined(words) if len(words) <= 4 else f"{joined(words[:2])} and {len(words) - 2} more"
