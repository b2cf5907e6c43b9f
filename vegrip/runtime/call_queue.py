"""Requests from other threads, served by the loop between two messages."""

import contextlib
import queue
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from vegrip.errors import DeviceError


class Inbox:
    """Calls waiting for the thread of the loop; serving an empty inbox costs one look at a queue."""

    def __init__(self) -> None:
        self._waiting: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()
        self._closed = False

    def put(self, call: Callable[[], Any]) -> Future[Any]:
        """Ask the loop to make ``call``; its result, or what it raises, comes in the future."""
        future: Future[Any] = Future()
        self._waiting.put((call, future))
        if self._closed:
            self._refuse()
        return future

    def close(self) -> None:
        """Refuse what waits and what still comes: the loop has ended."""
        self._closed = True
        self._refuse()

    def _refuse(self) -> None:
        with contextlib.suppress(queue.Empty):
            while True:
                _, future = self._waiting.get_nowait()
                future.set_exception(DeviceError("the node is ending"))

    def serve(self) -> None:
        """Make the calls that wait now."""
        while not self._waiting.empty():
            call, future = self._waiting.get()
            try:
                future.set_result(call())
            except Exception as error:  # noqa: BLE001 (goes to the one who asked)
                future.set_exception(error)
