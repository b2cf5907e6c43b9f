"""The virtual CAN bus, in one process and between two."""

import json
import os
import signal
import statistics
import subprocess
import sys
import threading
import time
from itertools import pairwise
from pathlib import Path

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from validation.bus_bytes import delivery_of, request_of, split_requests, unpack_request
from validation.faults.simulated_bus import Transmission
from vegrip.host.folders import runtime_folder
from vegrip.transport.canbus.bus_records import FD
from vegrip.transport.canbus.frame_time import FD_SIZES, BitTiming, BusFrame, frame_duration
from vegrip.transport.canbus.hub_wire import split_deliveries, unpack_delivery

PATIENCE = 60.0  # [s] of a machine that does much else
pytestmark = pytest.mark.usefixtures("runtime")


@pytest.fixture
def bus():
    opened = []

    def open_bus(channel="test", **options):
        opened.append(can.Bus(interface="vegrip", channel=channel, **options))
        return opened[-1]

    yield open_bus
    for each in opened:
        each.shutdown()


def frame(identifier=0x123, data=b"\x01\x02", **options):
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=False, **options)


def send_many(bus, count):
    for _ in range(count):
        bus.send(frame(data=bytes(8)))


def received(bus, count, timeout=PATIENCE):
    messages = [bus.recv(timeout) for _ in range(count)]
    assert None not in messages
    return messages


@pytest.mark.parametrize(
    "message",
    [
        frame(0x7FF, bytes(8)),
        frame(0, b""),
        frame(0x55, is_remote_frame=True, data=None, dlc=5),
        can.Message(arbitration_id=0x1ABCDEF0, data=b"abc", is_extended_id=True),
        frame(0x10, bytes(range(64)), is_fd=True, bitrate_switch=True, error_state_indicator=True),
        frame(0x11, bytes(12), is_fd=True),
    ],
)
def test_a_frame_arrives_as_it_was_sent(bus, message):
    sender, receiver = bus(fd=True), bus(fd=True)
    sender.send(message)
    (got,) = received(receiver, 1)
    assert got.equals(message, timestamp_delta=None, check_channel=False, check_direction=False)
    assert abs(got.timestamp - time.time()) < 5.0


def test_every_node_but_the_sender_gets_a_frame(bus):
    nodes = [bus(), bus(), bus()]
    echo = bus(receive_own_messages=True)
    nodes[0].send(frame())
    echo.send(frame(0x200))
    assert {m.arbitration_id for m in received(nodes[1], 2)} == {0x123, 0x200}
    assert {m.arbitration_id for m in received(echo, 2)} == {0x123, 0x200}
    assert [m.arbitration_id for m in received(nodes[0], 1)] == [0x200]


def test_frames_follow_each_other_no_faster_than_the_bit_rate_allows(bus):
    sender, receiver = bus(bitrate=125_000), bus()
    for i in range(20):
        sender.send(frame(0x100, bytes([i] * 8)), timeout=PATIENCE)
    got = received(receiver, 20)
    gaps = [after.timestamp - before.timestamp for before, after in pairwise(got)]
    expected = [
        frame_duration(BusFrame(0x100, bytes([i] * 8)), BitTiming(bitrate=125_000)) / 1e9
        for i in range(1, 20)
    ]
    waits = [gap - least for gap, least in zip(gaps, expected, strict=True)]
    assert min(waits) > -1e-6
    assert statistics.median(waits) < 1e-6  # back to back, but where the sender itself was late
    assert 0.0 < receiver.load() <= 1.0


def frames_before_an_urgent_one(bus):
    """Let five frames of 13 ms wait, then an urgent one; return how many of the five were sent before it."""
    busy, urgent, receiver = bus(bitrate=10_000), bus(), bus()
    for _ in range(5):
        busy.send(frame(0x700, bytes(8)), timeout=PATIENCE)
    received(receiver, 1)
    urgent.send(frame(0x001))
    return 1 + [m.arbitration_id for m in received(receiver, 5)].index(0x001)


def test_a_more_urgent_frame_overtakes_those_that_wait(bus):
    # where the machine keeps test or bus waiting, it comes later: it has many chances to come in time
    tries = (frames_before_an_urgent_one(bus) for _ in range(50))
    assert any(before <= 2 for before in tries), (
        "after the frame that has the bus, or the one that just began"
    )


def test_a_node_that_does_not_read_loses_frames_and_knows_how_many(bus):
    sender, receiver, reader = bus(fd=False), bus(), bus()
    count = 6000
    drained = threading.Thread(target=received, args=(reader, count))
    drained.start()
    for i in range(count):
        sender.send(frame(0x100, i.to_bytes(2, "big")), timeout=PATIENCE)
    drained.join()
    got = 0
    while receiver.recv(0.2) is not None:
        got += 1
    sender.send(frame(0x101))
    received(receiver, 1)
    assert receiver.overruns > 0
    assert got + receiver.overruns == count


def test_a_full_transmit_queue_says_so_and_never_blocks(bus):
    sender, _listener = bus(bitrate=10_000), bus(bitrate=10_000)
    start = time.monotonic()
    with pytest.raises(can.CanOperationError, match="overloaded"):
        send_many(sender, 1000)
    assert time.monotonic() - start < 2.0


def test_a_sender_that_is_alone_is_told_that_no_node_acknowledges(bus):
    alone = bus()
    alone.send(frame(0x100))
    while not alone.error_counters[0]:
        assert alone.state is not can.BusState.ERROR  # looks for news
    with pytest.raises(can.CanOperationError, match="no other node listens, so no frame is acknowledged"):
        send_many(alone, 5000)


def test_the_hub_ends_after_a_lone_node_that_left_with_a_full_queue(bus):
    alone = bus(bitrate=10_000)
    with pytest.raises(can.CanOperationError):
        send_many(alone, 1000)
    hub = hub_of(alone)
    alone.shutdown()
    deadline = time.monotonic() + 60.0
    while Path(f"/proc/{hub}").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not Path(f"/proc/{hub}").exists()


def test_filters_of_python_can_apply(bus):
    sender = bus()
    receiver = bus(can_filters=[{"can_id": 0x200, "can_mask": 0x7FF}])
    for identifier in (0x100, 0x200, 0x300):
        sender.send(frame(identifier))
    assert [m.arbitration_id for m in received(receiver, 1)] == [0x200]
    assert receiver.recv(0.05) is None


def test_the_first_sets_the_bit_rate_and_who_wants_another_is_refused(bus):
    first = bus(bitrate=500_000)
    assert bus().timing == first.timing
    with pytest.raises(can.CanInitializationError, match="500000"):
        bus(bitrate=250_000)


def test_fd_frames_need_fd(bus):
    classic, fd = bus(), bus(fd=True)
    with pytest.raises(can.CanOperationError, match="fd=True"):
        classic.send(frame(data=bytes(16), is_fd=True))
    fd.send(frame(0x1, bytes(16), is_fd=True))
    fd.send(frame(0x2))
    assert [m.arbitration_id for m in received(classic, 1)] == [0x2]
    assert (classic.fd_refused, fd.fd_refused) == (1, 0)


@pytest.mark.parametrize("channel", ["a/b", "", "../x", "x" * 200])
def test_a_bad_name_is_refused(bus, channel):
    with pytest.raises(can.CanInitializationError):
        bus(channel)


def test_channels_do_not_hear_each_other(bus):
    one, other = bus("one"), bus("other")
    one.send(frame())
    assert other.recv(0.05) is None


def test_open_channels_are_listed(bus):
    bus("here")
    assert {"interface": "vegrip", "channel": "here"} in can.detect_available_configs(["vegrip"])


def hub_of(bus):
    """Return the process that serves the bus; it may be about to write that down."""
    lock = runtime_folder("can") / f"{bus.channel}.lock"
    while not lock.read_text().endswith("\n"):
        time.sleep(0.01)
    return int(lock.read_text())


def test_the_death_of_the_hub_is_noticed_and_a_new_one_serves_the_next(bus):
    one = bus()
    os.kill(hub_of(one), signal.SIGKILL)
    with pytest.raises(can.CanOperationError, match="has gone"):
        one.recv(PATIENCE)
    again, other = bus(), bus()
    again.send(frame())
    received(other, 1)


CHILD = """
import json, sys, can
with can.Bus(interface="vegrip", channel="test", fd=True) as bus:
    bus.send(can.Message(arbitration_id=1, is_extended_id=False))
    for _ in range(200):
        message = bus.recv(60.0)
        answer = can.Message(arbitration_id=2, data=message.data, is_extended_id=False, is_fd=True)
        bus.send(answer, timeout=60.0)
print(json.dumps("done"))
"""


def test_two_processes_exchange_frames_and_the_hub_ends_after_them(bus, runtime):
    here = bus(fd=True)
    child = subprocess.Popen([sys.executable, "-c", CHILD], stdout=subprocess.PIPE, text=True)
    assert received(here, 1, timeout=PATIENCE)[0].arbitration_id == 1
    for i in range(200):
        data = i.to_bytes(2, "big") * 8
        here.send(frame(3, data, is_fd=True, bitrate_switch=True), timeout=PATIENCE)
        assert bytes(received(here, 1)[0].data) == data
    assert json.loads(child.communicate(timeout=PATIENCE)[0]) == "done"
    hub = hub_of(here)
    here.shutdown()
    deadline = time.monotonic() + 60.0
    while Path(f"/proc/{hub}").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not Path(f"/proc/{hub}").exists()
    assert not list(Path(runtime).rglob("*.bus"))


def test_many_that_open_at_once_share_one_bus(bus):
    opened = []
    threads = [threading.Thread(target=lambda: opened.append(bus())) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({hub_of(each) for each in opened}) == 1
    opened[0].send(frame())
    for other in opened[1:]:
        received(other, 1)


frames = st.builds(
    lambda identifier, size, fd: BusFrame(identifier, bytes(size), fd=fd),
    st.integers(0, 0x7FF),
    st.sampled_from(FD_SIZES[:9]),
    st.booleans(),
)


@given(st.integers(0, 2**63), frames)
def test_packets_carry_frames_unchanged(stamp, sent):
    stamp_back, back = unpack_request(request_of(stamp, sent))
    assert (stamp_back, back._replace(length_code=-1)) == (stamp, sent)
    packet = delivery_of(2**32 + 3, Transmission(stamp, stamp + 5, 7, sent), 11)
    delivery = unpack_delivery(packet)
    assert (delivery.end, delivery.busy, delivery.number, delivery.node) == (stamp + 5, 11, 3, 7)


@given(st.binary(max_size=200))
def test_any_bytes_are_a_frame_or_nothing(packet):
    for found in (unpack_request(packet), unpack_delivery(packet)):
        assert found is None or isinstance(found, tuple)


@given(frames=st.lists(frames, min_size=1, max_size=9))
def test_packets_of_several_frames_are_taken_apart_as_they_were_joined(frames):
    requests = [request_of(number, one) for number, one in enumerate(frames)]
    assert split_requests(b"".join(requests)) == [unpack_request(request) for request in requests]
    sent = [delivery_of(n, Transmission(n, n, 1, one), 0) for n, one in enumerate(frames)]
    assert split_deliveries(b"".join(sent)) == sent


@given(packet=st.binary(max_size=300))
def test_any_bytes_are_taken_apart_without_an_error(packet):
    assert b"".join(split_deliveries(packet)) == packet
    assert all(number >= 0 for number, _ in split_requests(packet))


def errors_of(bus, count, timeout=PATIENCE):
    got = []
    deadline = time.monotonic() + timeout
    while len(got) < count and time.monotonic() < deadline:
        message = bus.recv(timeout)
        if message is not None and message.is_error_frame:
            got.append(message)
    return got


def test_a_lone_node_is_told_that_nobody_acknowledges_and_turns_passive(bus):
    alone = bus()
    assert alone.state is can.BusState.ACTIVE
    alone.send(frame())
    errors = errors_of(alone, 17)
    assert len(errors) == 17
    assert {e.arbitration_id & ~0x200 for e in errors[:15]} == {0x020 | 0x080}  # not acknowledged
    assert [e.data[6] for e in errors[:15]] == [8 * i for i in range(1, 16)]
    assert alone.state is can.BusState.PASSIVE
    assert alone.error_counters == (128, 0)
    late = bus(error_frames=False)
    assert received(late, 1)[0].arbitration_id == 0x123, "the frame waited for the first who acknowledges it"


def test_a_node_that_only_listens_hears_all_and_says_nothing(bus):
    one, other, quiet = bus(), bus(), bus(listen_only=True)
    one.send(frame(0x300))
    assert received(quiet, 1)[0].arbitration_id == received(other, 1)[0].arbitration_id == 0x300
    assert quiet.state is can.BusState.PASSIVE
    with pytest.raises(can.CanOperationError, match="listen_only"):
        quiet.send(frame())


def test_a_node_whose_frames_all_fail_is_bus_off_and_comes_back(bus):
    bad, good = bus(bitrate=50_000, faults={"corruption": 1.0}), bus()
    deadline = time.monotonic() + 60.0
    refusal = ""
    while "bus-off" not in refusal and time.monotonic() < deadline:
        try:  # as long as it is off, which lasts 28 ms
            bad.send(frame())
        except can.CanOperationError as error:
            refusal = str(error)
        bad.recv(0.001)
    assert "bus-off" in refusal
    while bad.state is not can.BusState.ACTIVE and time.monotonic() < deadline:
        bad.recv(0.01)  # 128 * 11 bits: 28 ms
    sent, received = bad.error_counters
    assert received == 0
    assert sent % 8 == 0, "each frame that was on its way when it went off fails anew, and counts 8"
    assert sent < 128, "it counts from zero again; it was off at 256"
    assert errors_of(good, 1), "the others saw the errors"


def test_frames_brought_together_come_in_order_with_their_own_times_and_none_is_lost(bus):
    sender, patient, plain = bus(fd=True), bus(fd=True, patience=0.05), bus(fd=True)
    for number in range(40):
        length = FD_SIZES[number % len(FD_SIZES)]
        sender.send(frame(0x100 + number, bytes(length), is_fd=True, bitrate_switch=True))
    one_by_one, together = (
        [bus.take(time.monotonic() + PATIENCE) for _ in range(40)] for bus in (plain, patient)
    )
    assert together == one_by_one
    assert [delivery.frame.identifier for delivery in together] == list(range(0x100, 0x100 + 40))
    assert patient.overruns == 0


def test_one_who_waits_for_frames_together_gets_them_though_no_other_follows(bus):
    sender, patient = bus(), bus(patience=0.02)
    sender.send(frame(7))
    assert received(patient, 1)[0].arbitration_id == 7


def test_frames_asked_for_at_once_go_out_one_after_the_other(bus):
    sender, receiver = bus(fd=True), bus(fd=True)
    sender.put(*((identifier, bytes(8), FD) for identifier in (5, 3, 4, 1, 2)))
    got = received(receiver, 5)
    assert [message.arbitration_id for message in got] == [5, 3, 4, 1, 2]


def test_looking_at_the_state_loses_no_frames(bus):
    sender, receiver = bus(), bus()
    for i in range(20):
        sender.send(frame(0x100 + i))
    assert receiver.state is can.BusState.ACTIVE
    assert [m.arbitration_id for m in received(receiver, 20)] == list(range(0x100, 0x114))


def test_error_frames_can_be_left_out(bus):
    alone = bus(error_frames=False)
    alone.send(frame())
    deadline = time.monotonic() + 60.0
    while alone.state is not can.BusState.PASSIVE and time.monotonic() < deadline:
        assert alone.recv(0.05) is None
    assert alone.state is can.BusState.PASSIVE


def test_a_fault_that_does_not_exist_is_refused_by_name(bus):
    with pytest.raises(can.CanInitializationError, match="babbel"):
        bus(faults={"babbel": 1})


def test_lost_and_delayed_frames_on_the_wall_clock(bus):
    lossy, slow, receiver = bus(faults={"loss": 1.0}), bus(faults={"delay": 0.05}), bus()
    asked = time.time()
    lossy.send(frame(0x1))
    slow.send(frame(0x2))
    (got,) = received(receiver, 1)
    assert got.arbitration_id == 0x2
    assert got.timestamp - asked >= 0.05


def test_requests_that_are_cut_off_are_none_at_all():
    first, second = (request_of(time, BusFrame(0x10, bytes(time))) for time in (4, 8))
    for length in range(1, len(first + second)):
        expected = [unpack_request(first)] if length == len(first) else []
        assert split_requests((first + second)[:length]) == expected
