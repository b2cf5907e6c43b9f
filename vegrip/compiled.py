"""One way to compile: numba in nopython mode, cached on disk, with numpy's rules for division by zero.

numba is loaded when the first function is called that it compiles: it takes 0.2 s and 65 MB, and a node that
runs by C does not need it.
"""

import threading
import time
from collections.abc import Callable
from functools import cache, update_wrapper
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar, cast

from vegrip.compiling import announce_compiling

if TYPE_CHECKING:
    from numba.core.event import Event

F = TypeVar("F", bound=Callable[..., object])
NEWS_PERIOD_S = 3.0  # [s] between two sentences of progress
GENERATED = "vegrip_generated_"
"""How the names of generated modules begin."""
_COMPILING = threading.RLock()


class Announcer:
    """Says that numba is at work on a model, and how far it is: not for what comes from the cache."""

    said = False
    functions = 0
    """Of the generated modules that were loaded to be compiled; not all of them are called."""

    def __init__(self) -> None:
        self._compiled: set[tuple[str, str]] = set()
        self._since = self._reported = 0.0  # [s]

    def notify(self, event: "Event") -> None:
        (self.on_start if event.is_start else self.on_end)(event)

    def on_start(self, event: "Event") -> None:
        """Say it when a function of a generated module begins to compile."""
        module, name = _function_of(event)
        if not module:
            return
        now = time.monotonic()
        if not self.said:
            self.said, self._since, self._reported = True, now, now
            announce_compiling()
        elif now - self._reported >= NEWS_PERIOD_S:
            self._reported = now
            announce_compiling(f"compiling {name}: {self._done()}, {now - self._since:.0f} s so far")

    def on_end(self, event: "Event") -> None:
        if (function := _function_of(event))[0]:
            self._compiled.add(function)

    def _done(self) -> str:
        """Return how many functions are compiled, and of how many where that is known.

        How many a module of vegrip itself has is not: only what was generated was counted when it was loaded.
        """
        generated = sum(module.startswith(GENERATED) for module, _ in self._compiled)
        if generated < len(self._compiled) or generated >= self.functions:
            return f"{len(self._compiled)} compiled before it"
        return f"{generated} of at most {self.functions} functions are done"


def _function_of(event: "Event") -> tuple[str, str]:
    function = getattr(event.data["dispatcher"], "py_func", None)
    module = getattr(function, "__module__", "") or ""
    return (module, str(getattr(function, "__name__", ""))) if module.startswith("vegrip") else ("", "")


announcer = Announcer()


@cache
def load_numba() -> ModuleType:
    """Return numba, which from now on reports to the announcer what it compiles."""
    import numba  # noqa: PLC0415
    from numba.core import event  # noqa: PLC0415

    event.Listener.register(Announcer)
    event.register("numba:compile", announcer)  # type: ignore[no-untyped-call]
    return numba


class CompiledOnCall:
    """A function that numba compiles when it is called first, with those of its module that it may call."""

    def __init__(self, function: Callable[..., object]) -> None:
        self.py_func = function
        self._dispatcher: Callable[..., object] | None = None
        update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> object:
        return (self._dispatcher or self.dispatcher())(*arguments)

    def dispatcher(self) -> Callable[..., object]:
        """Return what numba makes of the function; in the function's module it takes the place of this."""
        with _COMPILING:
            names = self.py_func.__globals__
            for name, function in list(names.items()):
                if isinstance(function, CompiledOnCall):
                    names[name] = function._made()
            return self._made()

    def _made(self) -> Callable[..., object]:
        if self._dispatcher is None:
            compile_ = load_numba().njit(cache=True, error_model="numpy", nogil=True)
            self._dispatcher = compile_(self.py_func)
        return self._dispatcher


def njit(function: F) -> F:
    """Compile ``function`` on first use.

    Trap: numba's disk cache looks only at the file of the function itself. A compiled function must not
    call compiled functions of another module, or edits there run stale code in silence; code generated
    from several sources goes into one file named by the hash of its content.
    """
    return cast("F", CompiledOnCall(function))
