# SPDX-License-Identifier: MIT
"""Threads of BLAS, which NumPy and SciPy start by themselves."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


def one_blas_thread(work: Callable[P, R]) -> Callable[P, R]:
    """The function with one thread of BLAS: of small matrices, its threads only wait for each other, at full load.

    The limit holds for the whole process until the function returns or raises.
    """

    @wraps(work)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        with ThreadpoolController().limit(limits=1, user_api="blas"):  # of what is loaded by now
            return work(*args, **kwargs)

    return limited
