"""A server for Foxglove on loopback."""

import asyncio
import os
from collections.abc import Awaitable, Callable

import pytest

from tests.bridges.foxglove_peer import PATIENCE


@pytest.fixture(autouse=True)
def stays_quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands that give way run in the process of the tests, whose later tests would be slow."""
    monkeypatch.setattr(os, "nice", lambda _: 0)


@pytest.fixture
def serving(runtime, monkeypatch):
    """Run a coroutine function with the port of a server, which is ended after it."""
    pytest.importorskip("websockets")
    from vegrip.bridges import foxglove_server
    from vegrip.bridges.foxglove_channels import Json
    from vegrip.bridges.foxglove_server import FoxgloveServer

    monkeypatch.setattr(
        foxglove_server, "LOOK_PERIOD", 0.05
    )  # [s] and not a second, until a client hears of channels

    def run(source, conversation: Callable[..., Awaitable[None]], encoding=None):
        server = FoxgloveServer(source, encoding or Json())

        async def main():
            port = asyncio.get_running_loop().create_future()
            task = asyncio.create_task(server.run("127.0.0.1", 0, port.set_result))
            try:
                await conversation(await asyncio.wait_for(port, PATIENCE))
            finally:
                task.cancel()
                await asyncio.gather(task, return_exceptions=True)

        asyncio.run(main())
        server.close()
        return server

    return run
