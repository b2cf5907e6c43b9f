"""Frames taken from the virtual bus at once are those that are taken one by one."""

import random
import socket
from dataclasses import asdict

import pytest

from validation.bus_bytes import delivery_of
from validation.faults.simulated_bus import Transmission
from vegrip.transport.can_endpoint import CanEndpoint
from vegrip.transport.canbus import virtual_can
from vegrip.transport.canbus.frame_time import FD_SIZES, BitTiming, BusFrame
from vegrip.transport.codec import CanCodec, Frame

NOW = 10**12


@pytest.fixture
def two(monkeypatch):
    """Two endpoints on the bus, and the sockets into which the test puts what the bus brings them."""
    made = []
    for _ in range(2):
        ours, hub = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        for one in (ours, hub):
            one.setblocking(False)
        answer = {"node": 1, "timing": asdict(BitTiming()), "busy": 0}
        monkeypatch.setattr(virtual_can, "_join", lambda *_, ours=ours, answer=answer: (ours, answer))
        bus = virtual_can.VegripBus("test", fd=True, patience=0.02)
        made.append((CanEndpoint(bus, CanCodec(("thumb", "index"), fd=True)), hub, bus))
    yield made
    for endpoint, hub, _ in made:
        endpoint.close()
        hub.close()


def deliveries(seed: int, *, plain: bool) -> list[bytes]:
    draw = random.Random(seed)  # noqa: S311
    number, busy, made = 2**32 - 20, 0, []
    for i in range(60):
        odd = not plain and draw.random() < 0.1
        fd = not (odd and draw.random() < 0.5)
        size = draw.choice(FD_SIZES if fd else FD_SIZES[:9])
        frame = BusFrame(
            draw.randrange(1 << 11), draw.randbytes(size), fd=fd, extended=odd and fd,
            has_bit_rate_switch=fd and draw.random() < 0.5, length_code=FD_SIZES.index(size),
        )  # fmt: skip
        busy += 5000
        made.append(delivery_of(number, Transmission(NOW + i, NOW, 2, frame), busy))
        number += 1 if plain or draw.random() < 0.95 else 2
    return made


def one_by_one(endpoint: CanEndpoint) -> list[Frame]:
    frames = []
    while (frame := endpoint.next_frame(0.0)) is not None:
        frames.append(frame)
    return frames


@pytest.mark.parametrize("plain", [True, False])
@pytest.mark.parametrize("seed", range(6))
def test_frames_and_counts_are_the_same(two, seed, plain):
    told = deliveries(seed, plain=plain)
    for _, hub, _ in two:
        for at in range(0, 60, 7):
            hub.send(b"".join(told[at : at + 7]))
    (quick, _, bus), (slow, _, other) = two
    block = quick.take_block()
    assert (block is not None) == plain
    came = block.frames() if block is not None else one_by_one(quick)
    expected = one_by_one(slow)
    assert came == expected
    if block is not None:
        newest = {frame.arbitration_id: frame for frame in expected}
        assert {frame.arbitration_id: frame for frame in block.newest()} == newest
    assert (bus.overruns, bus._next_number, bus._load._busy) == (
        other.overruns, other._next_number, other._load._busy,
    )  # fmt: skip
    assert quick.rejected == slow.rejected


@pytest.mark.parametrize("broken", [b"x", b"\0" * 27, b"\xff" * 40])
def test_bytes_that_are_no_deliveries_are_left_to_be_looked_at_one_by_one(two, broken):
    (endpoint, hub, _), _ = two
    hub.send(b"".join(deliveries(0, plain=True)[:3]) + broken)
    assert endpoint.take_block() is None
    assert len(one_by_one(endpoint)) == 3


def test_nothing_is_an_empty_block(two):
    (endpoint, _, _), _ = two
    block = endpoint.take_block()
    assert block is not None
    assert block.frames() == block.newest() == []


def test_a_bus_that_has_gone_is_told_by_the_next_look(two):
    (endpoint, hub, _), _ = two
    hub.send(deliveries(0, plain=True)[0])
    hub.close()
    assert endpoint.take_block() is None
    assert endpoint.next_frame(0.0) is not None
    assert endpoint.next_frame(0.0) is None
    assert endpoint.rejected["bus_lost"] == 1
