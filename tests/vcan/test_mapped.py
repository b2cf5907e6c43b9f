"""A hand of another make over the kernel: its states come, and once they do, the frames of others do not."""

import time
from contextlib import ExitStack, closing

import can
import pytest

from vegrip.messages import ForceCommand, Reason
from vegrip.transport.open import Hand, open_endpoint

DBC = """VERSION ""
NS_ :
BS_:
BU_: Hand
BO_ 2566803489 TIP: 4 Hand
 SG_ Fz : 7|16@0- (0.01,0) [-300|300] "N" X
 SG_ Depth : 23|16@0- (0.001,0) [-32|32] "mm" X
BO_ 512 SET: 2 X
 SG_ Grip : 7|16@0+ (0.01,0) [0|50] "N" Hand
"""
MAP = """
database = "theirs.dbc"
rate = 100.0
[fingers.thumb.normal_force]
signal = "TIP.Fz"
[fingers.thumb.displacement]
signal = "TIP.Depth"
zero_is_measured = true
[fingers.thumb.command]
signal = "SET.Grip"
"""
TIP = 0x18FE5021
PATIENCE = 20.0  # [s]


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "theirs.dbc").write_text(DBC)
    (tmp_path / "hand.toml").write_text(MAP)
    return tmp_path


@pytest.fixture
def mapped():
    """Give a function that opens the hand of a map as a node does."""
    with ExitStack() as stack:

        def make(path):
            table = {"interface": "socketcan", "channel": "vcan0", "map": str(path)}
            return stack.enter_context(closing(open_endpoint(table, Hand(("thumb",)))))

        yield make


def tip(newtons):
    data = round(100 * newtons).to_bytes(2, "big", signed=True) + (1250).to_bytes(2, "big")
    return can.Message(arbitration_id=TIP, data=data, is_extended_id=True)


def other(identifier, extended):
    return can.Message(arbitration_id=identifier, data=bytes(8), is_extended_id=extended)


def hear(endpoint, bus, message):
    """Send until a state comes."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        bus.send(message)
        if found := endpoint.receive(0.1):
            return found[0]
    raise AssertionError("nothing came")


def test_frames_of_others_are_left_out_by_the_kernel_once_the_hand_was_heard(folder, bus, mapped):
    hand, node = bus(), mapped(folder / "hand.toml")
    codec = node._parts[0].endpoint._codec  # what the program was brought
    for identifier, extended in ((0x123, False), (TIP & 0x7FF, False), (TIP + 1, True)):
        hand.send(other(identifier, extended))
    state = hear(node, hand, tip(2.5))
    assert (state.normal_force, state.displacement) == (pytest.approx(2.5), pytest.approx(1.25e-3))
    node.receive(0.1)  # what was on its way before the filters
    before = codec.foreign
    assert before == 3
    for identifier, extended in ((0x123, False), (TIP & 0x7FF, False), (TIP + 1, True)):
        hand.send(other(identifier, extended))
    assert hear(node, hand, tip(3.0)).normal_force == pytest.approx(3.0)
    assert codec.foreign == before


def test_commands_leave_with_their_own_identifier(folder, bus, mapped):
    hand, node = bus(), mapped(folder / "hand.toml")
    now = time.monotonic_ns()
    node.send(ForceCommand(now, "thumb", 0, 2.0, 0.0, Reason.HOLD, now + 100_000_000))
    message = hand.recv(PATIENCE)
    assert (message.arbitration_id, message.is_extended_id, message.data.hex()) == (0x200, False, "00c8")
