"""The virtual bus brings a node what passes its acceptance filters, by the rule of python-can."""

import time

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from validation.bus_bytes import unpack_request
from validation.faults.simulated_bus import SimulatedBus
from vegrip.messages import FingertipState, ForceCommand, NodeStatus, Reason, SlipMargin
from vegrip.runtime.echo import EchoNode
from vegrip.transport.canbus.bus_records import MOST_FILTERS
from vegrip.transport.canbus.carry import accepts
from vegrip.transport.canbus.frame_time import BitTiming
from vegrip.transport.canbus.hub_wire import EXTENDED_FLAG, pack_filters, pairs_of, unpack_filters
from vegrip.transport.codec import CanCodec
from vegrip.transport.codec.database import layouts
from vegrip.transport.open import Hand, open_endpoint

pytestmark = pytest.mark.usefixtures("runtime")

WORDS = st.integers(0, (1 << 29) - 1)
FILTERS = st.lists(
    st.fixed_dictionaries({"can_id": WORDS, "can_mask": WORDS}, optional={"extended": st.booleans()}),
    min_size=1,
    max_size=8,
)


def member(filters):
    """Return a node that wants what passes."""
    model = SimulatedBus(BitTiming())
    model.attach(1)
    model.accept(1, pairs_of(filters))
    return model.node(1)


@given(filters=FILTERS, identifier=WORDS, extended=st.booleans())
def test_a_frame_passes_as_python_can_has_it(filters, identifier, extended):
    if not extended:
        identifier &= 0x7FF
    bus = can.Bus("rule", interface="virtual", can_filters=filters)
    with bus:
        message = can.Message(arbitration_id=identifier, is_extended_id=extended)
        key = identifier | EXTENDED_FLAG if extended else identifier
        assert accepts(member(filters), key) == bus._matches_filters(message)


@given(filters=FILTERS)
def test_filters_go_over_the_wire_and_are_no_frame(filters):
    packet = pack_filters(pairs_of(filters))
    assert unpack_filters(packet) == pairs_of(filters)
    assert unpack_request(packet) is None
    assert unpack_filters(packet[:-1]) is None


def frame(identifier):
    return can.Message(arbitration_id=identifier, data=b"\1", is_extended_id=False)


def heard(bus, sender, *identifiers, last=0x10):
    """Return what comes of ``identifiers`` and a last frame that passes all filters of these tests."""
    for identifier in (*identifiers, last):
        sender.send(frame(identifier), timeout=60.0)
    got = []
    while not got or got[-1] != last:
        got.append(bus.recv(60.0).arbitration_id)
    return got


LAST = {"can_id": 0x10, "can_mask": 0x7FF}


def test_what_does_not_pass_is_neither_brought_nor_counted_as_lost():
    with can.Bus(interface="vegrip", channel="filters") as sender:
        wanted = [LAST, {"can_id": 0x120, "can_mask": 0x7F0}]
        with can.Bus(interface="vegrip", channel="filters", can_filters=wanted) as bus:
            assert heard(bus, sender, 0x11F, 0x120, 0x12F, 0x130) == [0x120, 0x12F, 0x10]
            sender.send(frame(0x500))
            sender.send(frame(0x10))
            assert bus.take(time.monotonic() + 60.0).frame.identifier == 0x10, "the short way, too"
            assert bus.overruns == 0
            bus.set_filters([LAST])
            heard(bus, sender)
            assert heard(bus, sender, 0x120) == [0x10]
            bus.set_filters(None)
            heard(bus, sender)
            assert heard(bus, sender, 0x120, 0x7FF) == [0x120, 0x7FF, 0x10]


def test_error_frames_pass_every_filter():
    faults = {"corruption": 0.6, "seed": 1}
    with (
        can.Bus(interface="vegrip", channel="errors", can_filters=[LAST]) as bus,
        can.Bus(interface="vegrip", channel="errors", faults=faults) as sender,
    ):
        sender.send(frame(0x10))
        kinds = [bus.recv(60.0).is_error_frame]
        while kinds[-1]:
            kinds.append(bus.recv(60.0).is_error_frame)
        assert len(kinds) > 1


def test_more_filters_than_a_controller_has_are_refused():
    many = [LAST] * (MOST_FILTERS + 1)
    with pytest.raises(can.CanInitializationError, match="filters"):
        can.Bus(interface="vegrip", channel="many", can_filters=many)


KINDS = (FingertipState, ForceCommand, NodeStatus)


@pytest.mark.parametrize("hand", [0, 3, 7])
def test_all_but_the_reports_and_the_other_hands_passes(hand):
    pairs = CanCodec(("thumb",), fd=True, hand=hand).filters(KINDS)
    model = SimulatedBus(BitTiming())
    model.attach(1)
    model.accept(1, pairs)
    owner = {}
    for layout in layouts().layouts:
        for part in layout.parts:
            for identifier in range(part.base, part.base + 64):
                owner[identifier] = (layout.schema.cls, (identifier - part.base) // 8)
    for identifier in range(2048):
        kind, whose = owner.get(identifier, (FingertipState, hand))
        expected = kind in KINDS and whose == hand
        assert accepts(model.node(1), identifier) == expected, hex(identifier)


def test_a_node_hears_states_and_other_commanders_and_no_reports_of_others():
    table, hand = {"kind": "can", "channel": "chosen"}, Hand(("thumb",))
    with open_endpoint(table, hand) as node, open_endpoint(table, hand) as other:
        node.select(EchoNode.received_messages)
        now = time.monotonic_ns()
        other.send(FingertipState(now, "thumb", 1, normal_force=1.0))
        node.receive(5.0)  # from here on the filters are in force
        other.send(SlipMargin(now, "thumb", 1))
        other.send(ForceCommand(now, "thumb", 1, 1.0, 0.0, Reason.HOLD, now + 10**8))
        (got,) = node.receive(5.0)
        assert isinstance(got, ForceCommand)
        assert node.rejected == {}
