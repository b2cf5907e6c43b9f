"""The node that grips and the virtual hand, each a process, over the bus of the kernel; a third watches."""

import os
import signal
import subprocess
import sys
import time

import pytest

from vegrip.messages import FingertipState, ForceCommand, Lifecycle, NodeStatus, SlipMargin
from vegrip.runtime.registry import running_nodes

# Rates for a machine with one slow CPU: this is about what arrives, not about how fast.
LAUNCH = """
fingers = ["thumb", "index"]

[transport]
kind = "can"
interface = "socketcan"
channel = "vcan0"
fd = {fd}

[[node]]
program = "grasp_force"
wait = true
restart = "on-failure"
loop.tick_period = 0.02
loop.status_period = 0.2
parameters.report_period = 0.1

[[node]]
program = "virtual_hand"
required = true
loop.tick_period = 0.02
loop.status_period = 0.2
[node.parameters]
disturbed = false
hand.fingers = ["thumb", "index"]
hand.x = [0.0, 0.0]
hand.y = [0.0, 0.0]
hand.step = 2e-3
hand.rings = 4
hand.spokes = 8
hand.sensor.rate = 50.0
"""

TORN = {"incomplete", "counter", "lost", "other"}
"""The parts of a message must come within 5 ms: a sender that this one CPU leaves alone for longer has torn
its message, which is then refused. Nothing else may be wrong with a frame."""


@pytest.fixture(scope="module", params=[True, False], ids=["fd", "classic"])
def launched(request, tmp_path_factory):
    """Both programs, started as a user starts them."""
    folder = tmp_path_factory.mktemp("launch")
    file = folder / "kernel.toml"
    before = os.environ.get("VEGRIP_RUNTIME_DIR")
    os.environ["VEGRIP_RUNTIME_DIR"] = str(folder / "run")
    file.write_text(LAUNCH.format(fd=str(request.param).lower()))
    command = [sys.executable, "-m", "vegrip", "launch", str(file)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    yield process, request.param
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=60)
    os.environ.pop("VEGRIP_RUNTIME_DIR")
    os.environ |= {"VEGRIP_RUNTIME_DIR": before} if before else {}
    assert process.returncode == 0, output


def watched(endpoint, enough, patience=400.0):
    """Return what was on the bus until ``enough`` of the messages so far."""
    messages = []
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        messages += endpoint.receive(0.2)
        if enough(messages):
            return messages
    raise AssertionError(f"not enough: {[type(m).__name__ for m in messages][-20:]}")


def of(messages, cls, **values):
    return [m for m in messages if isinstance(m, cls) and all(getattr(m, k) == v for k, v in values.items())]


def gripped(messages):
    """Whether a grip that its node trusts has been seen for a while, and a status that says so."""
    held = [m for m in of(messages, SlipMargin) if m.margin.valid and m.lower_bound > 0.0]
    return len(held) > 20 and len(of(messages, NodeStatus, state=Lifecycle.ACTIVE)) > 3


def grip_node():
    (found,) = [node for node in running_nodes() if node.name == "/grasp_force"]
    return found.pid


def test_a_grip_is_held_over_the_kernels_bus(launched, endpoint):
    _, fd = launched
    watcher = endpoint(fd=fd)
    messages = watched(watcher, gripped)
    for finger in ("thumb", "index"):
        states, commands = (of(messages, cls, finger=finger) for cls in (FingertipState, ForceCommand))
        assert states[-1].normal_force > 0.3
        assert commands
        assert all(0.0 < command.normal_force <= 15.0 for command in commands)
    assert set(watcher.rejected) <= TORN
    assert set(of(messages, NodeStatus, node="grasp_force")[-1].rejected) <= TORN


def test_a_node_that_was_killed_comes_back_to_the_kernels_bus(launched, endpoint):
    process, fd = launched
    watcher = endpoint(fd=fd)
    first = grip_node()
    os.kill(first, signal.SIGKILL)
    silent = watched(watcher, lambda messages: len(of(messages, NodeStatus, node="virtual_hand")) > 5)
    assert not of(silent[len(silent) // 2 :], ForceCommand)
    again = watched(watcher, lambda messages: len(of(messages, ForceCommand)) > 10)
    assert of(again, ForceCommand)[-1].normal_force > 0.0
    assert grip_node() != first
    assert process.poll() is None
