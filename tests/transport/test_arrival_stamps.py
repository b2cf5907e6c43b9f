"""Datagrams are stamped when they reach this machine, not when they are read."""

import random
import socket
import time

import pytest

from vegrip.clock import NS
from vegrip.transport.byte_link import SO_TIMESTAMPING, STAMPS, opener, stamps_of

DEVICE_AHEAD = 37 * NS  # [ns] a clock in TAI


@pytest.fixture
def line():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device:
        device.bind(("127.0.0.1", 0))
        link = opener("udp", f"127.0.0.1:{device.getsockname()[1]}", 0, 0, "")(True)
        link.write(b"begin")
        _, peer = device.recvfrom(16)
        yield lambda data: device.sendto(data, peer), link
        link.close()


def told(kernel: int, own: int) -> list[tuple[int, int, bytes]]:
    data = STAMPS.pack(*divmod(kernel, NS), 0, 0, *divmod(own, NS))
    return [(socket.SOL_SOCKET, SO_TIMESTAMPING, data)]


def test_a_datagram_has_the_time_when_the_kernel_received_it(line):
    send, link = line
    before = time.monotonic_ns()
    send(b"one")
    sent = time.monotonic_ns()
    send(b"two")
    assert link.read() == b"one"
    assert before - NS // 10_000 <= link.arrived <= sent + NS // 10_000  # between two looks at two clocks
    first = link.arrived
    assert link.read() == b"two"
    assert link.arrived >= first
    assert link.read() == b""


def test_what_is_no_stamp_is_none():
    assert stamps_of([]) == (0, 0)
    assert stamps_of([(socket.SOL_SOCKET, SO_TIMESTAMPING, b"short")]) == (0, 0)
    assert stamps_of(told(3 * NS + 5, 7)) == (3 * NS + 5, 7)


def test_the_clock_of_the_interface_takes_the_jitter_of_the_kernel_away_and_says_how_much_there_was(line):
    _, link = line
    drawn = random.Random(3)  # noqa: S311 (the same in every run)
    errors, offset = [], time.time_ns() - time.monotonic_ns()
    for number in range(400):
        true = time.monotonic_ns() - NS // 2 + number * NS // 1000
        late = round(drawn.expovariate(1.0 / 50_000))  # [ns] until the kernel looks
        errors.append(link._arrival(told(true + offset + late, true + DEVICE_AHEAD)) - true)
    assert max(errors[20:]) - min(errors[20:]) < 20_000
    assert 20e-6 < link.clock.estimate().jitter < 120e-6
