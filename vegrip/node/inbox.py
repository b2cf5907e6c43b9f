"""Requests from other threads, served by the loop between two messages."""

import queue
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any


class Inbox:
    """Calls waiting for the thread of the loop; serving an empty inbox costs one look at a queue."""

    def __init__(self) -> None:
        self._waiting: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()

    def put(self, call: Callable[[], Any]) -> Future[Any]:
        """Ask the loop to make ``call``; its result, or what it raises, comes in the future."""
        future: Future[Any] = Future()
        self._waiting.put((call, future))
        return future

    def serve(self) -> None:
        """Make the calls that wait now."""
        while not self._waiting.empty():
            call, future = self._waiting.get()
            try:
                future.set_result(call())
            except Exception as error:  # noqa: BLE001 (goes to the one who asked)
                future.set_exception(error)
