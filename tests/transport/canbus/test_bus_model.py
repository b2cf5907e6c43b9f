"""Laws of the bus: one frame at a time, the lowest identifier first, nothing lost, nothing invented."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.transport.canbus.bus_scripts import is_healthy
from validation.faults.simulated_bus import SimulatedBus
from vegrip.transport.canbus.bus_events import BusLoad, NodeFaults
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame, frame_duration

TIMING = BitTiming(bitrate=500_000)
US = 1000

requests = st.lists(
    st.tuples(st.integers(0, 3000 * US), st.integers(0, 3), st.integers(0, 0x7FF)), min_size=1, max_size=40
)


def new_bus():
    bus = SimulatedBus(TIMING)
    for node in range(10):
        bus.attach(node)
    return bus


def run(asked, steps=()):
    """Ask in the order of time and advance to the end, by way of the times ``steps``."""
    bus = new_bus()
    sent = []
    steps = sorted(steps)
    for time, node, identifier in sorted(asked):
        while steps and steps[0] <= time:
            sent += bus.advance(steps.pop(0))
        bus.request(time, node, BusFrame(identifier, bytes([node])))
    for step in steps:
        sent += bus.advance(step)
    return sent + bus.advance(10**12)


@given(requests)
def test_every_frame_is_sent_once_and_takes_its_duration(asked):
    sent = run(asked)
    assert sorted((t.node, t.frame.identifier) for t in sent) == sorted((n, i) for _, n, i in asked)
    assert all(t.end - t.start == frame_duration(t.frame, TIMING) for t in sent)


@given(requests)
def test_two_frames_are_never_on_the_bus_at_once_and_it_is_never_idle_without_need(asked):
    sent = run(asked)
    assert sent[0].start == min(time for time, _, _ in asked)
    for before, after in pairwise(sent):
        assert after.start >= before.end
    for i, sending in enumerate(sent[1:], start=1):
        asked_by_then = sum(time <= sent[i - 1].end for time, _, _ in asked)
        assert (sending.start == sent[i - 1].end) == (asked_by_then > i), "idle only when nobody waits"


@given(st.lists(st.integers(0, 0x7FF), min_size=1, max_size=8, unique=True))
def test_of_nodes_that_ask_together_the_lowest_identifier_goes_first(identifiers):
    sent = run([(0, node, identifier) for node, identifier in enumerate(identifiers)])
    assert [t.frame.identifier for t in sent] == sorted(identifiers)


def test_a_node_sends_its_own_frames_in_order_whatever_their_identifiers():
    bus = new_bus()
    for identifier in (0x700, 0x001, 0x300):
        bus.request(0, 1, BusFrame(identifier))
    assert [t.frame.identifier for t in bus.advance(10**9)] == [0x700, 0x001, 0x300]


def test_a_frame_on_the_bus_is_not_interrupted_by_a_more_urgent_one():
    sent = run([(0, 1, 0x700), (10 * US, 2, 0x001), (10 * US, 3, 0x000)])
    assert [t.frame.identifier for t in sent] == [0x700, 0x000, 0x001]


@given(requests, st.lists(st.integers(0, 3000 * US), max_size=10))
def test_the_result_does_not_depend_on_when_time_is_looked_at(asked, steps):
    """Provided each look comes when all requests up to then are known."""
    assert run(asked, steps) == run(asked)


def test_a_request_that_becomes_known_late_waits_for_the_bus():
    bus = new_bus()
    bus.request(0, 1, BusFrame(0x700))
    assert bus.advance(5 * US) == []  # 0x700 has the bus
    bus.request(0, 2, BusFrame(0x001))
    assert [t.frame.identifier for t in bus.advance(10**9)] == [0x700, 0x001]


@given(requests)
def test_the_next_event_is_when_there_is_something_to_do(asked):
    bus = new_bus()
    for time, node, identifier in sorted(asked):
        bus.request(time, node, BusFrame(identifier))
    sent = 0
    while (event := bus.next_event()) is not None:
        sent += len(bus.advance(event))
    assert sent == len(asked)


@given(requests)
def test_load_is_the_sum_of_durations_over_the_time(asked):
    sent = run(asked)
    load = BusLoad()
    for t in sent:
        load.add(t.end, t.end - t.start)
    busy, elapsed = sum(t.end - t.start for t in sent), sent[-1].end - sent[0].start
    assert load.share(sent[-1].end) == pytest.approx(busy / elapsed)


def test_load_forgets_what_is_older_than_its_window():
    load = BusLoad()
    for i in range(1000):
        load.add(i * 1000 * US, 500 * US)
    assert load.share(999 * 1000 * US) == pytest.approx(0.5, rel=0.01)
    assert load.share(1500 * 1000 * US) == pytest.approx(0.25, rel=0.01)
    assert load.share(5 * 10**9) == 0.0


def test_an_untouched_bus_has_no_load():
    assert BusLoad().share(123) == 0.0


def faulty_bus():
    bus = SimulatedBus(TIMING)
    for node in range(4):
        bus.attach(node, faults=NodeFaults(corruption=0.3, misreading=0.1, seed=node))
    return bus


@pytest.mark.parametrize("make", [new_bus, faulty_bus])
@given(requests, st.lists(st.integers(0, 4000 * US), max_size=30))
def test_to_conclude_a_frame_first_changes_nothing(make, asked, looks):
    one, other = make(), make()
    told, wanted = [], []
    steps = [(time, False, node, identifier) for time, node, identifier in asked]
    for time, look, node, identifier in sorted(steps + [(time, True, 0, 0) for time in looks]):
        if look:
            told += [*one.conclude(time), *one.advance(time)]
            wanted += other.advance(time)
        else:
            for bus in (one, other):
                bus.request(time, node, BusFrame(identifier, bytes([node])))
    assert told + one.advance(10**9) == wanted + other.advance(10**9)


def test_a_bus_is_healthy_until_a_node_has_errors_or_is_to_have_some() -> None:
    bus = SimulatedBus(BitTiming())
    bus.attach(1)
    bus.attach(2)
    assert is_healthy(bus)
    bus.endure(2, NodeFaults(corruption=0.5))
    assert not is_healthy(bus)
    bus.endure(2, NodeFaults())
    assert is_healthy(bus)
    bus.detach(2)
    bus.request(0, 1, BusFrame(1, b""))
    bus.advance(1_000_000)  # nobody acknowledges
    assert not is_healthy(bus)
