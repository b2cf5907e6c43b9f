"""Laws of the limit on connections: whoever connects, and however often, the process lives and serves on."""

import resource
import socket
import subprocess
import sys
import time
from collections import Counter

import pytest
import zmq

from vegrip.errors import DeviceError
from vegrip.host import descriptors
from vegrip.runtime.registry import Entry, ask
from vegrip.transport import connection_limit
from vegrip.transport.connection_limit import ConnectionLimit
from vegrip.transport.curve import resolve

PATIENCE = 30.0  # [s] on a busy machine
pytestmark = pytest.mark.usefixtures("runtime")


def until(condition):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.01)
    return False


def knock(path):
    """Connect once, without a word; None when there is nothing to connect to."""
    knocking = socket.socket(socket.AF_UNIX)
    try:
        knocking.connect(path)
    except OSError:
        knocking.close()
        return None
    return knocking


def is_shut(path):
    knocking = knock(path)
    if knocking is not None:
        knocking.close()
    return knocking is None


@pytest.fixture
def limited():
    with zmq.Context() as context:
        server = context.socket(zmq.ROUTER)
        server.linger = 0
        counts = Counter()
        address = resolve("ipc:limited")
        limit = ConnectionLimit(server, address, counts)
        server.bind(address)
        limit.start()
        yield limit, server, address, counts
        limit.close()
        server.close()


def test_beyond_the_limit_nobody_comes_in_until_one_goes(limited, monkeypatch):
    limit, server, address, counts = limited
    monkeypatch.setattr(connection_limit, "MAX_CONNECTIONS", 5)
    path = address.removeprefix("ipc://")
    inside = []
    while (knocking := knock(path)) is not None and len(inside) < 4000:
        inside.append(knocking)
    assert until(lambda: limit.connected() >= 5)
    assert until(lambda: is_shut(path))
    assert counts["connections"] >= 1
    with zmq.Context() as context, context.socket(zmq.DEALER) as late:
        late.linger = 0
        late.connect(address)
        late.send(b"hello")
        assert not server.poll(300)
        for each in inside:
            each.close()
        assert server.poll(int(PATIENCE * 1000)), "it came in by itself"
    assert until(lambda: limit.connected() == 0)


def test_every_connection_that_ends_makes_room_however_it_ends(limited):
    limit, _, address, counts = limited
    path = address.removeprefix("ipc://")
    for rubbish in (b"", b"\xff", b"GET / HTTP/1.1\r\n\r\n", bytes(100), b"\xff" * 100):
        came = [each for _ in range(20) if (each := knock(path)) is not None]
        for each in came:
            if rubbish:
                each.sendall(rubbish)
            each.close()
        assert until(lambda: limit.connected() == 0)
    assert not counts


def test_when_descriptors_get_scarce_by_whatever_uses_them_nobody_comes_in(limited, monkeypatch):
    _, server, address, counts = limited
    path = address.removeprefix("ipc://")
    monkeypatch.setattr(descriptors, "free", lambda: 10)
    assert until(lambda: is_shut(path))
    assert counts["connections"] == 1
    monkeypatch.undo()
    with zmq.Context() as context, context.socket(zmq.DEALER) as asking:
        asking.linger = 0
        asking.connect(address)
        asking.send(b"hello")
        assert server.poll(int(PATIENCE * 1000))


def test_who_connects_and_says_nothing_keeps_no_place(limited, monkeypatch):
    limit, server, address, _ = limited
    monkeypatch.setattr(connection_limit, "MAX_CONNECTIONS", 3)
    silent = []
    while (knocking := knock(address.removeprefix("ipc://"))) is not None and len(silent) < 4000:
        silent.append(knocking)
    with zmq.Context() as context, context.socket(zmq.DEALER) as asking:
        asking.linger = 0
        asking.connect(address)
        asking.send(b"hello")
        assert server.poll(int(PATIENCE * 1000))
    for each in silent:
        each.close()
    assert until(lambda: limit.connected() == 0)


NODE = """
import resource, sys
from vegrip.runtime.control_socket import ControlServer
from vegrip.runtime.telemetry_socket import TelemetrySocket
from vegrip.transport.codec.msgpack_codec import MsgpackCodec
from vegrip.runtime.registry import Entry

class Calls:
    calls = {"state": lambda: "well"}

resource.setrlimit(resource.RLIMIT_NOFILE, (1024, 1024))
entry = Entry("/grip", "echo")
sink = TelemetrySocket(entry.telemetry, MsgpackCodec())
server = ControlServer(entry.control, Calls())
print("ready", flush=True)
sys.stdin.readline()
server.close()
sink.close()
"""


@pytest.mark.long
def test_a_node_out_of_descriptors_is_not_aborted_and_answers_when_they_are_free_again():
    entry = Entry("/grip", "echo")
    node = subprocess.Popen(
        [sys.executable, "-c", NODE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert node.stdout.readline() == "ready\n"
        for path in (entry.control.removeprefix("ipc://"), entry.telemetry.removeprefix("ipc://")):
            inside = []
            end = time.monotonic() + 1.5
            while len(inside) < 1500 and time.monotonic() < end and node.poll() is None:
                if (knocking := knock(path)) is not None:
                    inside.append(knocking)
            assert node.poll() is None
            assert inside
            for each in inside:
                each.close()
            assert ask(entry, "state", patience=PATIENCE) == "well"
        node.communicate("end\n", timeout=PATIENCE)
        assert node.returncode == 0
    finally:
        node.kill()
        node.wait()


def test_without_a_descriptor_to_look_with_none_is_free(monkeypatch):
    def none_left(_):
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(descriptors.os, "listdir", none_left)
    assert descriptors.free() == 0


@pytest.fixture
def limits(monkeypatch):
    now = {"limits": (1024, 4096)}
    monkeypatch.setattr(resource, "getrlimit", lambda _: now["limits"])
    monkeypatch.setattr(resource, "setrlimit", lambda _, limits: now.update(limits=limits))
    return now


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ((1024, 4096), (4096, 4096)),
        ((1024, 1 << 20), (descriptors.WANTED_DESCRIPTORS, 1 << 20)),
        ((1024, resource.RLIM_INFINITY), (descriptors.WANTED_DESCRIPTORS, resource.RLIM_INFINITY)),
        ((1 << 20, 1 << 20), (1 << 20, 1 << 20)),
        ((600, 600), (600, 600)),
    ],
)
def test_a_node_takes_the_descriptors_it_may_have_and_gives_none_back(limits, before, after):
    limits["limits"] = before
    descriptors.require_descriptors(descriptors.NODE_NEEDS)
    assert limits["limits"] == after


def test_with_too_few_descriptors_a_node_is_refused_with_the_remedy(limits):
    limits["limits"] = 60, 60
    with pytest.raises(DeviceError, match=r"only 60 files .*ulimit -n 512"):
        descriptors.require_descriptors(descriptors.NODE_NEEDS)
