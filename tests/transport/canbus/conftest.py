"""The compiled loop of the bus is there for all tests of the bus, not only for those that come second."""

import os

import pytest

from vegrip.host.compiled_folder import compiler
from vegrip.transport.canbus import compiled_bus


@pytest.fixture(scope="session", autouse=True)
def compiled_loop():
    """Compile it, where there is a compiler."""
    if compiler() is not None and os.environ.get("VEGRIP_KERNEL") in (None, "c"):
        compiled_bus.compile_library()
