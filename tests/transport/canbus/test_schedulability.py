"""Response times against the published example, against a closed form, and against the simulated bus."""

import math
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from validation.faults.simulated_bus import SimulatedBus, Transmission
from vegrip.transport.canbus.frame_time import FD_SIZES, BitTiming, BusFrame, frame_duration, longest_duration
from vegrip.transport.canbus.traffic import (
    Stream,
    TrafficPlan,
    busy_period,
    fifo_response_times,
    forecast_traffic,
    response_times,
    utilisation,
)

MS = 1e-3


def test_the_example_by_which_the_older_analysis_was_refuted():
    """Davis, Burns, Bril, Lukkien 2007: the second instance of C takes 3.5 ms, the first only 3."""
    a, b, c = Stream(1, 1 * MS, 2.5 * MS), Stream(2, 1 * MS, 3.5 * MS), Stream(3, 1 * MS, 3.5 * MS)
    assert response_times([a, b, c], bit=1e-6) == pytest.approx([2 * MS, 3 * MS, 3.5 * MS])


def test_a_stream_alone_waits_for_nothing():
    assert response_times([Stream(1, 1e-4, 1e-3)], 1e-6) == [1e-4]


def test_jitter_adds_to_the_response():
    plain, late = Stream(1, 1e-4, 1e-3), Stream(1, 1e-4, 1e-3, jitter=2e-4)
    assert response_times([late], 1e-6)[0] == pytest.approx(response_times([plain], 1e-6)[0] + 2e-4)


def test_the_most_urgent_waits_for_the_longest_of_the_others():
    streams = [Stream(1, 1e-4, 1e-2), Stream(2, 3e-4, 1e-2), Stream(3, 2e-4, 1e-2)]
    assert response_times(streams, 1e-6)[0] == pytest.approx(4e-4)


def test_an_overloaded_bus_makes_the_less_urgent_wait_for_ever():
    streams = [Stream(1, 0.6 * MS, MS), Stream(2, 0.6 * MS, MS)]
    assert math.isfinite(response_times(streams, 1e-6)[0])
    assert response_times(streams, 1e-6)[1] == math.inf
    assert fifo_response_times(streams, 1e-6) == [math.inf] * 2


def test_in_one_fifo_all_wait_for_all():
    streams = [Stream(i, 1e-4, 1e-2, queue="node") for i in range(5)]
    assert fifo_response_times(streams, 1e-6) == pytest.approx([5e-4] * 5)


def test_in_a_fifo_a_later_frame_may_wait_longer_than_the_first():
    """Two streams of one queue, every 1 ms, beside 0.5 ms that are more urgent than one of them.

    At the start 0.5 + 0.4 + 0.2 ms are queued. A millisecond later it is 0.5 + 2 (0.4 + 0.2) ms, of which 1.7
    ms: the bus is busy until then, and what came at 1 ms waits 0.2 ms longer than the first for the blocking.
    """
    fast, slow = Stream(0, 0.4 * MS, MS, queue="b"), Stream(2, 0.2 * MS, MS, queue="b")
    other = Stream(1, 0.5 * MS, 3.0 * MS, queue="a")
    assert fifo_response_times([fast, other, slow], 1e-6) == pytest.approx([1.2 * MS, 1.7 * MS, 1.2 * MS])


def test_a_fifo_of_one_stream_waits_no_less_than_by_priority_and_no_longer_than_the_bus_is_busy():
    streams = [Stream(i + 1, MS, period * MS, queue=str(i)) for i, period in enumerate((2.5, 3.5, 3.5))]
    by_priority, fifo = response_times(streams, 1e-6), fifo_response_times(streams, 1e-6)
    assert busy_period(streams) == pytest.approx(7.0 * MS)
    assert all(a <= b <= 7.0 * MS for a, b in zip(by_priority, fifo, strict=True))


classic = st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)).map(lambda f: BusFrame(*f))
worst_bytes = st.sampled_from([0x00, 0xFF, 0x0F, 0xF0, 0x78, 0x87, 0x3C, 0xC3])
fd = st.tuples(
    st.integers(0, 0x7FF), st.sampled_from(FD_SIZES), st.lists(worst_bytes, min_size=64, max_size=64)
).map(lambda f: BusFrame(f[0], bytes(f[2][: f[1]]), fd=True, has_bit_rate_switch=True))


@pytest.mark.parametrize(("length", "bits"), [(0, 55), (1, 65), (7, 125), (8, 135)])
def test_the_longest_classic_frame_is_the_published_one(length, bits):
    assert longest_duration(0x123, length, False, BitTiming()) == 1000 * bits


@given(st.one_of(classic, fd))
def test_no_frame_is_longer_than_the_longest(frame):
    timing = BitTiming()
    assert frame_duration(frame, timing) <= longest_duration(
        frame.identifier, len(frame.data), frame.fd, timing
    )


streams_of_nodes = st.lists(
    st.tuples(st.integers(0, 3), st.integers(1, 8), st.sampled_from([1, 2, 5, 10])), min_size=2, max_size=12
)


def observed(streams, nodes, sizes, timing, seed, fifo):
    """Longest time from queuing to arrival of each stream in 0.2 s of the simulated bus."""
    random = Random(seed)  # noqa: S311
    bus = SimulatedBus(timing)
    queues = sorted(set(nodes)) if fifo else range(len(streams))
    for node in [*queues, 99]:
        bus.attach(node)
    phases = [random.choice([0.0, random.random() * stream.period]) for stream in streams]
    asked = [
        (phase + n * stream.period, i)
        for i, (stream, phase) in enumerate(zip(streams, phases, strict=True))
        for n in range(int((0.2 - phase) / stream.period))
    ]
    queued = {i: [] for i in range(len(streams))}
    for time, i in sorted(asked):
        stamp = round(time * 1e9)
        queued[i].append(stamp)
        data = random.choice([bytes(sizes[i]), random.randbytes(sizes[i])])
        bus.request(stamp, nodes[i] if fifo else i, BusFrame(streams[i].priority, data))
    worst = [0.0] * len(streams)
    for sent in bus.advance(10**9):
        if isinstance(sent, Transmission):
            i = sent.frame.identifier
            worst[i] = max(worst[i], (sent.end - queued[i].pop(0)) * 1e-9)
    return worst


@settings(max_examples=60)
@given(streams_of_nodes, st.integers(0, 1000), st.booleans())
def test_the_simulated_bus_never_exceeds_the_prediction(kinds, seed, fifo):
    timing = BitTiming(500_000)
    streams = [
        Stream(i, longest_duration(i, size, False, timing) * 1e-9, period * 5 * MS, queue=str(node))
        for i, (node, size, period) in enumerate(kinds)
    ]
    nodes, sizes = [kind[0] for kind in kinds], [kind[1] for kind in kinds]
    predicted = (fifo_response_times if fifo else response_times)(streams, 2e-6)
    seen = observed(streams, nodes, sizes, timing, seed, fifo)
    assert utilisation(streams) < 1.0
    for longest, bound in zip(seen, predicted, strict=True):
        assert longest <= bound + 1e-6


def test_the_prediction_is_reached_when_all_is_queued_at_once():
    """The critical instant: everything at once, just after the longest frame of least priority began."""
    timing = BitTiming(500_000)
    bus = SimulatedBus(timing)
    for node in range(6):
        bus.attach(node)
    frames = [BusFrame(i, bytes(8)) for i in range(5)]
    durations = [frame_duration(frame, timing) for frame in frames]
    streams = [Stream(i, d * 1e-9, 0.1) for i, d in enumerate(durations)]
    bus.request(0, 4, frames[4])
    for i in range(4):
        bus.request(1, i, frames[i])
    ends = {sent.node: sent.end for sent in bus.advance(10**9) if isinstance(sent, Transmission)}
    predicted = response_times(streams, 2e-6)
    assert [ends[i] * 1e-9 for i in range(4)] == pytest.approx(predicted[:4], abs=2.1e-6)  # a stuff bit


# --- plans


def test_a_state_and_a_command_per_finger_and_period_make_the_load():
    only = forecast_traffic(
        TrafficPlan(fingers=1, rate=100.0, report_rate=0.0, health_rate=0.0, status_rate=0.0)
    )
    assert [row.name for row in only.rows] == ["ForceCommandFd", "FingertipStateFd"]
    assert only.worst_load == pytest.approx(100.0 * sum(row.longest for row in only.rows))
    assert only.load < only.worst_load
    assert only.fits


def test_five_fingers_at_500_hz_fill_a_classic_bus_and_not_an_fd_bus():
    """As proto/README.md says."""
    assert forecast_traffic(TrafficPlan(fd=False)).worst_load > 1.0
    assert not forecast_traffic(TrafficPlan(fd=False)).fits
    assert forecast_traffic(TrafficPlan(), fifo=False).fits
    assert 0.5 < forecast_traffic(TrafficPlan()).load < 0.7


def test_load_grows_with_fingers_rates_and_hands_and_falls_with_bit_rate():
    base = forecast_traffic(TrafficPlan()).load
    assert forecast_traffic(TrafficPlan(fingers=4)).load < base
    assert forecast_traffic(TrafficPlan(rate=250.0)).load < base
    assert forecast_traffic(TrafficPlan(data_bitrate=8_000_000)).load < base
    assert forecast_traffic(TrafficPlan(hands=2)).load == pytest.approx(2 * base, rel=1e-3)


def test_a_command_comes_after_the_state_it_answers():
    told = forecast_traffic(TrafficPlan(fingers=2), fifo=False)
    response = {row.identifier: row.response for row in told.rows}
    for row in told.rows:
        if row.name == "ForceCommandFd":
            assert row.response > response[row.answers]
            assert row.response == pytest.approx(row.wait + response[row.answers])


@pytest.mark.parametrize(("fd", "parts"), [(True, 1), (False, 1), (False, 2), (False, 3)])
def test_what_a_node_sends_answers_the_last_frame_of_the_state(fd, parts):
    plan = TrafficPlan(fingers=2, hands=2, fd=fd, state_parts=parts)
    rows = forecast_traffic(plan).rows
    owners = {row.owner for row in rows if row.name.startswith("ForceCommand")}
    assert len(owners) == 4
    for owner in owners:
        own = [row for row in rows if row.owner == owner]
        states = [row.identifier for row in own if row.name.startswith("FingertipState")]
        assert len(states) == parts
        answers = {row.answers for row in own if not row.name.startswith("FingertipState")}
        assert answers == {max(states)}
