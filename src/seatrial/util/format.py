# SPDX-License-Identifier: MIT
"""Numbers, lists and tables as text."""

from collections.abc import Sequence

import numpy as np

from seatrial.util.printing import table_columns


def joined(words: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def shortened(words: Sequence[str]) -> str:
    """As `joined`; of more than four the first two, and the number of others."""
    return joined(words) if len(words) <= 4 else f"{joined(words[:2])} and {len(words) - 2} more"


def times(count: int) -> str:
    """`once`, or `3 times`."""
    return "once" if count == 1 else f"{count} times"


def plus_minus(value: float, error: float) -> str:
    """A value and its standard error, both to the error's second digit; 0: given."""
    if not 0.0 < error < np.inf:
        return f"{value:.6g}"
    digits = 1 - int(f"{error:.1e}".partition("e")[2])
    if digits > 7 or max(abs(value), error) >= 1e5:
        return f"{value:.3e} ± {error:.1e}"
    shown = round(value, max(0, digits)) + 0.0  # no -0.00
    return f"{shown:.{max(0, digits)}f} ± {error:.{max(0, digits)}f}"


def percent(share: float) -> str:
    """A share to two digits, or to whole per cent where there are more."""
    return f"{100.0 * share:.2g} %" if share < 0.995 else f"{100.0 * share:.0f} %"


def chance(p: float) -> str:
    """A p value, without a false 0."""
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    spare: Sequence[int] = (),
    text: Sequence[int] = (0,),
) -> str:
    """Columns of text to the left, those of numbers to the right.

    spare: columns that a narrow terminal lacks, the first one first. text: which columns are text.
    """
    columns, left = table_columns.get(), list(range(len(head)))
    for i in spare:
        wide = sum(2 + max(len(row[k]) for row in (head, *rows)) for k in left)
        if columns is None or wide <= columns:
            break
        left.remove(i)
    shown = [[row[i] for row in (head, *rows)] for i in left]
    widths = [max(map(len, column)) for column in shown]
    padded = [
        [cell.ljust(width) if i in text else cell.rjust(width) for cell in column]
        for i, column, width in zip(left, shown, widths, strict=True)
    ]
    return "\n".join("  " + "  ".join(row).rstrip() for row in zip(*padded, strict=True))


def sensible(value: float) -> str:
    """A percentage, or a value in standard errors, with sensible digits; what rounds to 0 has no sign."""
    digits = 0 if abs(value) >= 10.0 else 1
    return f"{round(value, digits) + 0.0:.{digits}f}"
