"""A node of ours on one side, the package ``canopen`` on the other, on a virtual bus or that of a kernel."""

import os
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, closing, contextmanager
from importlib.resources import files

import canopen
import pytest
from e2e.p11 import e2e_p11_protect

from vegrip.clock import WallClock
from vegrip.runtime.echo import EchoNode, EchoParameters
from vegrip.runtime.handle import NodeHandle
from vegrip.runtime.runner import LoopSettings, Runner
from vegrip.transport.open import Hand, open_endpoint

FINGERS = ("thumb", "index")
GRASP, THUMB, INDEX = 16, 32, 33
KERNEL = bool(os.environ.get("VEGRIP_VCAN"))
FINGERTIP, GRASP_FORCE = (
    str(files("vegrip.proto").joinpath(f"{name}.eds")) for name in ("fingertip", "grasp_force")
)


def eventually(condition: Callable[[], object], patience: float = 60.0) -> object:
    """Return what ``condition`` gives as soon as it is true."""
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        if found := condition():
            return found
        time.sleep(0.01)
    raise AssertionError("did not happen in time")


def protected(kind: int, counter: int, payload: bytes, *, last: bool = True) -> bytes:
    """Return the PDO of a finger: the classic frame ``kind`` with counter and checksum."""
    data = bytearray([0, counter | 0x10 | 0x80 * last]) + payload
    e2e_p11_protect(data, kind, increment_counter=False)
    return bytes(data)


@pytest.fixture
def bus():
    """What both sides open: ``(interface, channel)``, of this test alone."""
    with tempfile.TemporaryDirectory(prefix="vg-") as folder:
        before = os.environ.get("VEGRIP_RUNTIME_DIR")
        os.environ["VEGRIP_RUNTIME_DIR"] = f"{folder}/r"
        yield (
            {"interface": "socketcan", "channel": "vcan0"}
            if KERNEL
            else {"interface": "vegrip", "channel": "c"}
        )
        os.environ.pop("VEGRIP_RUNTIME_DIR")
        os.environ |= {"VEGRIP_RUNTIME_DIR": before} if before else {}


@pytest.fixture
def other(bus):
    """The other side: a network of the package ``canopen``, with threads of its own."""
    network = canopen.Network()
    network.connect(**bus, **({} if KERNEL else {"bitrate": 1_000_000}))
    yield network
    for node in network.values():
        node.nmt.stop_heartbeat() if isinstance(node, canopen.LocalNode) else None
    for thread in threading.enumerate():  # python-can stops a cyclic task without waiting for its last frame
        if thread.name.startswith("Cyclic send task"):
            thread.join()
    network.disconnect()


@pytest.fixture
def fingers(other):
    """Both fingers, as another maker would build them."""

    def make(node, eds=FINGERTIP):
        finger = other.create_node(node, canopen.import_od(eds, node))
        finger.nmt.state = "INITIALISING"
        finger.nmt.state = "PRE-OPERATIONAL"
        for pdo in (finger.tpdo, finger.rpdo):
            pdo.read(from_od=True)
        return finger

    return make


class Ours:
    """A runner in a thread of its own."""

    def __init__(self, runner, endpoint, autostart=True):
        self.runner, self.endpoint = runner, endpoint
        runner.change("configure")
        endpoint.supervise(NodeHandle(runner), autostart=autostart)
        self._thread = threading.Thread(target=runner.run)
        self._thread.start()

    @property
    def state(self):
        return self.runner.state.name

    @property
    def settled(self):
        """Whether it is active and has dropped what came before."""
        status = self.runner.status
        return status is not None and status.state.name == "ACTIVE"

    def close(self):
        self.runner.stop()
        self._thread.join()


@pytest.fixture
def grasp(bus):
    """A function that starts a grasp force node of ours, with an echo or another node in it."""
    with ExitStack() as stack:

        def start(node=None, autostart=True, names=FINGERS, **table):
            endpoint = open_endpoint({"kind": "canopen", **bus, **table}, Hand(names))
            stack.enter_context(closing(endpoint))
            settings = LoopSettings(tick_period=0.02, status_period=0.1)
            runner = Runner(
                node or EchoNode("grasp_force", EchoParameters()), endpoint, WallClock(), settings
            )
            return stack.enter_context(closing(Ours(runner, endpoint, autostart)))

        yield start


@contextmanager
def hand_of_ours(bus, **table):
    """The fingers of a hand of ours, served by a thread; takes messages to send."""
    endpoint = open_endpoint({"kind": "canopen", "role": "hand", **bus, **table}, Hand(FINGERS))
    stop, heard, to_send = threading.Event(), [], []

    def serve():
        while not stop.is_set():
            heard.extend(endpoint.receive(0.01))
            while to_send:
                endpoint.send(to_send.pop(0))

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield heard, to_send, endpoint
    finally:
        stop.set()
        thread.join()
        endpoint.close()
