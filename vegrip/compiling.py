"""Says that code is being compiled, which takes seconds the first time and is silent by itself.

:func:`compile_listener` puts a listener in place; without one the logger ``vegrip`` gets a line, or a
terminal does.
"""

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SENTENCE = "compiles for this machine, once; later starts take it from the cache (about 30 s)"

log = logging.getLogger("vegrip")
_listeners: list[Callable[[str], None]] = []


@contextmanager
def compile_listener(listener: Callable[[str], None]) -> Iterator[None]:
    """Call ``listener`` with a sentence when compiling begins."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def announce_compiling(sentence: str = SENTENCE) -> None:
    """Say that compiling begins: to the innermost listener, else to the log, else to the terminal."""
    if _listeners:
        _listeners[-1](sentence)
    elif log.isEnabledFor(logging.INFO):
        log.info(sentence)
    elif sys.stderr is not None and sys.stderr.isatty():
        print(f"vegrip: {sentence}", file=sys.stderr)  # noqa: T201
