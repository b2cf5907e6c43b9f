"""Laws of a bus on which things go wrong: errors, confinement, acknowledgement, faults on purpose."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from validation.faults.simulated_bus import BusError, ErrorKind, SimulatedBus, StateChange, Transmission
from vegrip.transport.canbus.bus_events import ErrorState, NodeFaults
from vegrip.transport.canbus.frame_time import BitTiming, BusFrame, frame_duration

TIMING = BitTiming(500_000)
BIT = 2000  # [ns]
MS = 1_000_000
SECOND = 10**9
SENDER, RECEIVER, OTHER = 1, 2, 3
FRAME = BusFrame(0x123, b"\x55" * 8)


def bus(*nodes, **faulty):
    """A bus with ``nodes``; ``n1`` = faults of node 1."""
    made = SimulatedBus(TIMING)
    for node in nodes:
        made.attach(node, faults=faulty.get(f"n{node}", NodeFaults()))
    return made


def of(kind, events):
    return [event for event in events if isinstance(event, kind)]


# --- acknowledgement


def test_a_lone_node_turns_passive_after_16_errors_and_never_off():
    alone = bus(SENDER)
    alone.request(0, SENDER, FRAME)
    events = alone.advance(MS * 100)
    first = of(BusError, events)[:17]
    assert {error.kind for error in first} == {ErrorKind.ACK}
    (change,) = of(StateChange, events)
    assert (change.state, change.time) == (ErrorState.PASSIVE, first[15].end)
    alone.advance(3600 * SECOND)
    assert alone.state(SENDER) is ErrorState.PASSIVE
    assert alone.counters(SENDER) == (128, 0)
    assert alone.waiting(SENDER) == 1


def test_attempts_of_a_lone_node_follow_each_other_as_computed():
    alone = bus(SENDER)
    alone.request(0, SENDER, FRAME)
    errors = of(BusError, alone.advance(20 * MS))
    attempt = frame_duration(FRAME, TIMING) + (17 - 11) * BIT
    assert [e.end - e.start for e in errors] == [attempt] * len(errors)
    assert {b.start - a.end for a, b in pairwise(errors[:16])} == {0}
    assert {b.start - a.end for a, b in pairwise(errors[15:])} == {8 * BIT}


@given(st.lists(st.integers(1, 50 * MS), max_size=20, unique=True))
def test_how_often_one_looks_at_a_lone_node_changes_nothing(looks):
    watched, unwatched = bus(SENDER), bus(SENDER)
    for each in (watched, unwatched):
        each.request(0, SENDER, FRAME)
    for look in sorted(looks):
        watched.advance(look)
    for each in (watched, unwatched):
        each.advance(60 * MS)
        each.attach(RECEIVER)
        (sent,) = of(Transmission, each.advance(61 * MS))
        assert sent.end > 60 * MS
    assert watched.busy == unwatched.busy
    assert watched.counters(SENDER) == unwatched.counters(SENDER) == (127, 0)


def test_a_lone_passive_node_asks_for_nothing_until_somebody_comes():
    """Otherwise the process of the bus would wake up for each of its thousands of attempts a second."""
    alone = bus(SENDER)
    alone.request(0, SENDER, FRAME)
    while (event := alone.next_event()) is not None:
        assert event < 20 * MS
        alone.advance(event)


def test_a_frame_waits_for_the_first_who_acknowledges_it():
    alone = bus(SENDER)
    alone.request(0, SENDER, FRAME)
    alone.advance(50 * MS)
    alone.attach(OTHER, listen_only=True)
    assert not of(Transmission, alone.advance(100 * MS))
    alone.attach(RECEIVER)
    (sent,) = of(Transmission, alone.advance(101 * MS))
    assert sent.frame == FRAME


@given(st.integers(60 * MS, 62 * MS), st.integers(0, 3 * MS))
def test_who_comes_in_the_middle_of_an_attempt_gets_the_next_one(arrival, late):
    alone = bus(SENDER)
    alone.request(0, SENDER, FRAME)
    alone.advance(arrival)
    alone.attach(RECEIVER)
    event = alone.next_event()
    events = []
    while event is not None:
        events += alone.advance(event + late)
        event = alone.next_event()
    (sent,) = of(Transmission, events)
    assert arrival < sent.end < arrival + MS


def test_a_node_that_only_listens_cannot_send():
    quiet = bus(SENDER)
    quiet.attach(OTHER, listen_only=True)
    assert not quiet.request(0, OTHER, FRAME)
    assert quiet.advance(SECOND) == []


def test_frames_of_a_node_that_left_are_still_sent_if_somebody_is_there():
    pair = bus(SENDER, RECEIVER)
    for _ in range(3):
        pair.request(0, SENDER, FRAME)
    pair.advance(1)
    pair.detach(SENDER)
    assert len(of(Transmission, pair.advance(SECOND))) == 3
    pair.request(SECOND, RECEIVER, FRAME)
    pair.detach(RECEIVER)
    assert pair.next_event() is None


# --- bus-off


def test_a_node_whose_frames_all_fail_turns_off_after_32_and_comes_back_after_128_times_11_bits():
    broken = bus(SENDER, RECEIVER, n1=NodeFaults(corruption=1.0))
    for _ in range(5):
        broken.request(0, SENDER, FRAME)
    events = broken.advance(SECOND)
    errors, changes = of(BusError, events), of(StateChange, events)
    assert len(errors) == 32
    sender = [change for change in changes if change.node == SENDER]
    assert [change.state for change in sender] == [ErrorState.PASSIVE, ErrorState.OFF, ErrorState.ACTIVE]
    off, back = sender[1:]
    assert (off.time, off.dropped) == (errors[-1].end, 5)
    assert back.time == off.time + 128 * 11 * BIT
    assert broken.counters(SENDER) == (0, 0)
    assert broken.counters(RECEIVER) == (0, 32)


def test_a_node_that_is_off_sends_nothing():
    broken = bus(SENDER, RECEIVER, n1=NodeFaults(corruption=1.0))
    broken.request(0, SENDER, FRAME)
    while broken.state(SENDER) is not ErrorState.OFF:
        broken.advance(broken.next_event())
    assert not broken.request(20 * MS, SENDER, FRAME)


def test_on_a_busy_bus_every_frame_brings_a_node_that_is_off_one_step_back():
    broken = bus(SENDER, RECEIVER, OTHER, n1=NodeFaults(corruption=1.0))
    broken.request(0, SENDER, FRAME)
    for _ in range(300):
        broken.request(0, OTHER, BusFrame(0x700, bytes(8)))
    events = broken.advance(SECOND)
    off = next(e for e in events if isinstance(e, StateChange) and e.state is ErrorState.OFF)
    back = next(e for e in of(StateChange, events) if e.time > off.time and e.node == SENDER)
    assert len([e for e in of(Transmission, events) if off.time < e.end <= back.time]) == 128


def test_a_node_that_fails_in_less_than_one_of_nine_frames_is_never_off():
    """Eight good frames pay for a bad one."""
    for share, lasts in ((0.05, True), (0.4, False)):
        noisy = bus(SENDER, RECEIVER, n1=NodeFaults(corruption=share, seed=3))
        for i in range(3000):
            noisy.request(i * MS, SENDER, FRAME)
        off = [e for e in of(StateChange, noisy.advance(10 * SECOND)) if e.state is ErrorState.OFF]
        assert (not off) == lasts


# --- errors


@given(st.integers(0, 10_000), st.floats(0.0, 0.1))
def test_disturbed_frames_are_sent_again_none_lost_none_twice_none_out_of_order(seed, share):
    noisy = bus(SENDER, RECEIVER, n1=NodeFaults(corruption=share, seed=seed))
    frames = [BusFrame(0x100, bytes([i])) for i in range(60)]
    for i, frame in enumerate(frames):
        noisy.request(i * MS, SENDER, frame)
    events = noisy.advance(10 * SECOND)
    assert [sent.frame for sent in of(Transmission, events)] == frames
    ends = sorted((e.start, e.end) for e in events if not isinstance(e, StateChange))
    assert all(before[1] <= after[0] for before, after in pairwise(ends))
    assert noisy.busy == sum(end - start for start, end in ends)


@given(st.integers(0, 10_000), st.floats(0.0, 0.4), st.floats(0.0, 1.0))
def test_the_counters_follow_the_rules_of_fault_confinement(seed, corruption, misreading):
    """ISO 11898-1, counted here event by event."""
    faults = {"n1": NodeFaults(corruption=corruption, seed=seed), "n3": NodeFaults(misreading=misreading)}
    noisy = bus(SENDER, RECEIVER, OTHER, **faults)
    for i in range(60):
        noisy.request(i * MS, SENDER, FRAME)
    counters = {node: [0, 0] for node in (SENDER, RECEIVER, OTHER)}
    for event in noisy.advance(10 * SECOND):
        if isinstance(event, BusError):
            counters[SENDER][0] += 8
            for node in (RECEIVER, OTHER):
                counters[node][1] = min(counters[node][1] + (9 if node == event.found_by else 1), 255)
            assert event.counters == {node: tuple(counts) for node, counts in counters.items()}
        elif isinstance(event, Transmission):
            counters[SENDER][0] = max(counters[SENDER][0] - 1, 0)
            for node in (RECEIVER, OTHER):
                count = counters[node][1]
                better = 127 if count > 127 else max(count - 1, 0)
                counters[node][1] = min(count + 1, 255) if node == event.missed_by else better
        elif event.counters == (0, 0):
            counters[event.node] = [0, 0]  # back from bus-off
    assert {node: list(noisy.counters(node)) for node in counters} == counters


def test_a_receiver_that_misreads_costs_the_others_until_it_is_passive():
    deaf = bus(SENDER, RECEIVER, OTHER, n3=NodeFaults(misreading=1.0))
    for i in range(200):
        deaf.request(i * MS, SENDER, FRAME)
    events = deaf.advance(SECOND)
    assert len(of(BusError, events)) == 15  # nine for each, 15 * 9 > 127
    assert {error.found_by for error in of(BusError, events)} == {OTHER}
    sent = of(Transmission, events)
    assert len(sent) == 200
    assert {each.missed_by for each in sent[1:]} == {OTHER}
    assert deaf.state(OTHER) is ErrorState.PASSIVE
    assert deaf.counters(SENDER)[0] == deaf.counters(RECEIVER)[1] == 0, "all paid back by good frames"


def test_a_passive_sender_lets_others_go_first():
    broken = bus(SENDER, RECEIVER, OTHER, n1=NodeFaults(corruption=1.0))
    broken.request(0, SENDER, BusFrame(0x001, bytes(8)))
    while broken.state(SENDER) is not ErrorState.PASSIVE:
        broken.advance(broken.next_event())
    now = broken.next_event()
    broken.request(now - 4 * BIT, OTHER, BusFrame(0x7FF))
    events = broken.advance(now + MS)
    assert events[0].node == OTHER


def test_a_passive_sender_says_so_in_its_fd_frames():
    alone = SimulatedBus(TIMING)
    alone.attach(SENDER)
    alone.request(0, SENDER, BusFrame(0x10, bytes(8), fd=True))
    alone.advance(SECOND)
    alone.attach(RECEIVER)
    alone.request(SECOND, RECEIVER, BusFrame(0x11, bytes(8), fd=True))
    sent = of(Transmission, alone.advance(2 * SECOND))
    assert {each.node: each.frame.is_error_passive for each in sent} == {SENDER: True, RECEIVER: False}


# --- faults on purpose


def test_a_babbling_node_starves_those_above_its_identifier_only():
    noisy = bus(SENDER, RECEIVER, OTHER, n3=NodeFaults(babble=0x200))
    for i in range(100):
        noisy.request(i * MS, SENDER, BusFrame(0x100, bytes(8)))
        noisy.request(i * MS, RECEIVER, BusFrame(0x300, bytes(8)))
    sent = of(Transmission, noisy.advance(110 * MS))
    count = [sum(each.node == node for each in sent) for node in (SENDER, RECEIVER, OTHER)]
    assert count[0] == 100
    assert count[1] == 0
    assert noisy.busy / (110 * MS) > 0.99


def test_lost_frames_take_the_bus_and_reach_nobody():
    lossy = bus(SENDER, RECEIVER, n1=NodeFaults(loss=0.3, seed=1))
    for i in range(1000):
        lossy.request(i * MS, SENDER, FRAME)
    sent = of(Transmission, lossy.advance(2 * SECOND))
    assert len(sent) == 1000
    assert sum(each.is_lost for each in sent) == pytest.approx(300, abs=45)  # three standard deviations


def test_a_flipped_frame_differs_in_one_bit():
    bad = bus(SENDER, RECEIVER, n1=NodeFaults(flips=1.0))
    for i in range(50):
        bad.request(i * MS, SENDER, FRAME)
    for sent in of(Transmission, bad.advance(SECOND)):
        pairs = zip(sent.frame.data, FRAME.data, strict=True)
        assert sum((a ^ b).bit_count() for a, b in pairs) == 1


def test_a_delayed_frame_asks_for_the_bus_later_and_in_order():
    late = bus(SENDER, RECEIVER, n1=NodeFaults(delay=0.005, jitter=0.010))
    frames = [BusFrame(0x100, bytes([i])) for i in range(50)]
    for i, frame in enumerate(frames):
        late.request(i * MS, SENDER, frame)
    sent = of(Transmission, late.advance(SECOND))
    assert [each.frame for each in sent] == frames
    assert all(each.start >= i * MS + 5 * MS for i, each in enumerate(sent))


def test_the_same_seed_gives_the_same_errors():
    def errors(seed):
        noisy = bus(SENDER, RECEIVER, n1=NodeFaults(corruption=0.2, seed=seed))
        for i in range(100):
            noisy.request(i * MS, SENDER, FRAME)
        return of(BusError, noisy.advance(SECOND))

    assert errors(5) == errors(5)
    assert errors(5) != errors(6)
