"""Tests over the SocketCAN of a real kernel, run by ``make test-vcan``."""

import importlib.util
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from types import ModuleType

import can
import pytest

from vegrip.transport.endpoint import Endpoint
from vegrip.transport.open import Hand, open_endpoint

FINGERS = ("thumb", "index")


@pytest.fixture(scope="session", autouse=True)
def kernel() -> None:
    """Fail without vcan0 where these tests must run, skip them where nobody made it."""
    if not os.environ.get("VEGRIP_VCAN"):
        pytest.skip("these need vcan0 and vcan1; `make test-vcan` makes them and runs these tests")
    assert {"vcan0", "vcan1"} <= {name for _, name in socket.if_nameindex()}


@pytest.fixture(scope="session")
def links() -> ModuleType:
    """Give the functions that make, remove, raise and lower interfaces."""
    spec = importlib.util.spec_from_file_location("links", Path(__file__).parent / "links.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MakeEndpoint = Callable[..., Endpoint]
MakeBus = Callable[..., can.BusABC]


@pytest.fixture
def endpoint() -> Iterator[MakeEndpoint]:
    """Give a function that opens an endpoint as a node does."""
    with ExitStack() as stack:

        def make(number: int = 0, **table: object) -> Endpoint:
            settings = {"interface": "socketcan", "channel": "vcan0"} | table
            return stack.enter_context(closing(open_endpoint(settings, Hand(FINGERS, number))))

        yield make


@pytest.fixture
def bus() -> Iterator[MakeBus]:
    """Give a function that opens a bus without anything of vegrip."""
    with ExitStack() as stack:

        def make(channel: str = "vcan0", fd: bool = True, **options: object) -> can.BusABC:
            return stack.enter_context(can.Bus(interface="socketcan", channel=channel, fd=fd, **options))

        yield make
