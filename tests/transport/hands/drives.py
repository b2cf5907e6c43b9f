"""A drive of the box on a pty or a port of loopback, working in a thread of its own."""

import threading
import time

from vegrip.messages import ForceCommand, Reason
from vegrip.transport.hands.device_endpoint import PtyPort, SocketPort, VirtualDeviceEndpoint, virtual_device
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.products import map_of, virtual_text
from vegrip.transport.open import Hand, open_alone

PATIENCE = 20.0  # [s] on a busy machine


class Running:
    """A virtual drive, and endpoints of ours at it."""

    def __init__(self, name, folder):
        self.path = folder / f"{name}.toml"
        self.path.write_text(virtual_text(map_of(name)))
        plan = open_plan(self.path)
        self.transport = dict(plan.hand.transport)
        is_serial = self.transport["kind"] == "serial"
        self.port = PtyPort(str(folder / "tty")) if is_serial else SocketPort("tcp", "127.0.0.1:0")
        self.device = virtual_device(plan)
        self._endpoint = VirtualDeviceEndpoint(self.device, self.port, 1.0)
        self._stops = threading.Event()
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def _work(self):
        while not self._stops.is_set():
            self._endpoint.receive(0.002)

    @property
    def host(self):
        name, _, port = self.port.address.rpartition(":")
        return name, int(port)

    def open(self, **settings):
        table = {**self.transport, "address": self.port.address, "map": str(self.path), **settings}
        return open_alone(
            table, Hand(("jaw",)), "[transport]"
        )  # the protocol, below what steps are asked for

    def presses(self, force):
        return abs(self.device.forces.get("jaw", -1.0) - force) < 0.5

    def close(self):
        self._stops.set()
        self._thread.join()
        self.port.close()


def command(force, life=1.0):
    now = time.monotonic_ns()
    return ForceCommand(now, "jaw", 1, force, 0.0, Reason.HOLD, now + round(life * 1e9))


def until(endpoint, done):
    """Let the endpoint work until ``done`` says so."""
    end = time.monotonic() + PATIENCE
    while not done():
        assert time.monotonic() < end, (endpoint.conditions, dict(endpoint.rejected))
        endpoint.receive(0.005)


def press(endpoint, force, done):
    endpoint.send(command(force, PATIENCE))
    until(endpoint, done)
