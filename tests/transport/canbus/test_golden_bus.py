"""The bus answers as it always did, in Python and in C, and whatever bytes members send.

Here a part of the scripts; all of them by ``python tests/transport/canbus/bus_scripts.py`` and ``git diff``.
"""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.transport.canbus.bus_scripts import Script, digests, golden
from validation.bus_bytes import request_of, unpack_request
from validation.faults.simulated_bus import SimulatedBus, read_record
from vegrip.host.compiled_folder import compiler
from vegrip.transport.canbus import carry
from vegrip.transport.canbus.bus_records import OFF, PASSIVE, REMOTE
from vegrip.transport.canbus.carry import take_packet
from vegrip.transport.canbus.compiled_bus import CompiledBus, compile_library
from vegrip.transport.canbus.frame_time import FD_SIZES, BitTiming, BusFrame

NOW = 10**12  # [ns]


@pytest.mark.parametrize("groups", [range(1), range(3, 4), range(15, 16)])
def test_c_gives_the_golden_answers(groups):
    if compiler() is None:
        pytest.skip("no C compiler")
    found = digests(CompiledBus(compile_library()), groups)
    assert found == {name: golden()[name] for name in found}


def test_python_gives_the_golden_answers():
    found = digests(carry, range(7, 8))
    assert found == {name: golden()[name] for name in found}


@pytest.mark.parametrize("seed", range(0, 60, 7))
def test_counters_stay_within_their_registers_and_the_state_follows_from_them(seed):
    script = Script(seed, None)
    script.run()
    for node in (script.model.node(number) for number in script.nodes):
        assert 0 <= node.receive <= 255
        assert 0 <= node.transmit <= 263
        assert (node.state == OFF) == (node.transmit > 255)
        assert (node.state == PASSIVE) == (max(node.transmit, node.receive) > 127 and node.transmit <= 255)


def queued(packet):
    """Return what a packet puts into the queue of a node, and whether it was taken."""
    model = SimulatedBus(BitTiming(), carry)
    model.attach(1)
    record = model.record
    record.packet[: len(packet)] = packet
    is_taken = take_packet(record, record.order[0], len(packet), NOW)
    return [
        read_record(one.frame)._replace(length_code=-1) for one in record.requests[: model.queued]
    ], is_taken


HEADS = st.builds(
    struct.pack,
    st.just("<QIBB"),
    st.just(NOW),
    st.integers(0, 1 << 30),
    st.integers(0, 40),
    st.integers(0, 17),
)


def requests_in(packet):
    """Return the frames that a packet asks for, none unless it is made of requests throughout."""
    frames, at = [], 0
    while at < len(packet):
        flags, code = (packet[at + 12], packet[at + 13]) if len(packet) - at >= 14 else (0xFF, 0)
        end = at + 14 + (0 if flags & REMOTE else FD_SIZES[code & 15])
        asked = unpack_request(packet[at:end]) if flags < 32 else None
        if asked is None:
            return []
        frames.append(asked[1]._replace(length_code=-1))
        at = end
    return frames


@given(st.lists(st.one_of(HEADS, st.binary(max_size=80)), max_size=5).map(b"".join))
def test_of_any_bytes_exactly_the_requests_are_queued(packet):
    frames, is_taken = queued(packet)
    assert frames == requests_in(packet)
    assert is_taken == bool(frames)


def test_a_request_that_was_queued_too_early_or_in_the_future_is_not_believed():
    model = SimulatedBus(BitTiming(), carry)
    model.attach(1)
    for time in (0, NOW - 10**9, NOW - 1, NOW + 1, 1 << 63):
        packet = request_of(time, BusFrame(5))
        model.record.packet[: len(packet)] = packet
        take_packet(model.record, model.record.order[0], len(packet), NOW)
    times = [request.time for request in model.record.requests[:5]]
    assert times == [NOW - 10**9, NOW - 10**9, NOW - 1, NOW, NOW]
