"""Linear algebra on one thread: the matrices here are small, and BLAS threads that wait for them spin."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

from threadpoolctl import threadpool_limits

P = ParamSpec("P")
R = TypeVar("R")


def on_one_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Let ``function`` run without BLAS threads of its own; several of it may still run side by side."""
    return cast("Callable[P, R]", threadpool_limits.wrap(limits=1, user_api="blas")(function))
