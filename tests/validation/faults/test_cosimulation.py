"""Nodes on one simulated bus: repeatable, exact in time, and as hard to each other as real ones."""

from itertools import pairwise

import pytest

from validation.faults.cosimulation import Cosimulation
from validation.faults.simulated_can import SimulatedCan
from vegrip.clock import SimulatedClock
from vegrip.messages import FingertipState, ForceCommand
from vegrip.runtime import NodeBase
from vegrip.runtime.echo import EchoNode, EchoParameters
from vegrip.runtime.runner import LoopSettings
from vegrip.transport.codec import CanCodec

PERIOD = 0.002
LOOP = LoopSettings(tick_period=PERIOD)


class Source(NodeBase):
    """Sends a state at each tick and notes when its answer came."""

    def __init__(self):
        super().__init__("source")
        self.sent, self.answers_at = {}, {}

    def on_tick(self, now):
        seq = len(self.sent) + 1
        self.sent[seq] = now
        return [FingertipState(now, "index", seq, normal_force=1.0)]

    def on_message(self, message, now):
        if isinstance(message, ForceCommand):
            self.answers_at[message.seq] = now
        return ()


@pytest.fixture
def simulation():
    clock = SimulatedClock()
    return Cosimulation(SimulatedCan(clock), clock)


def endpoint(simulation):
    return simulation.bus.endpoint(CanCodec(("index",), fd=True))


def pair(simulation):
    source = Source()
    echo = simulation.add(EchoNode("echo", EchoParameters()), endpoint(simulation), LOOP)
    hand = simulation.add(source, endpoint(simulation), LOOP)
    return source, echo, hand


def test_every_state_is_answered_after_the_time_of_two_frames(simulation):
    source, _, _ = pair(simulation)
    simulation.run_until(1.0)
    delays = [source.answers_at[seq] - source.sent[seq] for seq in source.answers_at]
    assert len(delays) >= 499
    assert 150_000 < min(delays) < 250_000  # [ns] 48 and 24 bytes of CAN FD at 1 and 5 Mbit/s
    assert max(delays) < 500_000  # when both send their NodeStatus


def test_ticks_fall_on_their_grid(simulation):
    source, _, _ = pair(simulation)
    simulation.run_until(1.0)
    times = list(source.sent.values())
    assert {b - a for a, b in pairwise(times)} == {2_000_000}


def test_the_same_simulation_gives_the_same_times():
    def run():
        clock = SimulatedClock()
        simulation = Cosimulation(SimulatedCan(clock), clock)
        source, _, _ = pair(simulation)
        simulation.run_until(0.5)
        return source.sent, source.answers_at, simulation.bus.model.busy

    assert run() == run()


def test_a_killed_node_is_silent_at_once(simulation):
    source, echo, _ = pair(simulation)
    simulation.run_until(0.5)
    simulation.kill(echo)
    simulation.run_until(1.0)
    assert max(source.answers_at.values()) < 0.5e9
    again = simulation.add(EchoNode("echo", EchoParameters()), endpoint(simulation), LOOP)
    simulation.run_until(1.5)
    assert max(source.answers_at.values()) > 1.4e9
    assert again.runner.status is not None


def test_a_starved_node_answers_late_and_says_so(simulation):
    source, echo, _ = pair(simulation)
    simulation.run_until(0.5)
    simulation.starve(echo, 0.1)
    simulation.run_until(1.2)
    late = [source.answers_at[seq] - source.sent[seq] for seq in source.answers_at]
    assert 0.09e9 < max(late) < 0.11e9
    assert echo.runner.statistics.lateness_max >= 0.09e9
    assert echo.runner.statistics.deadline_misses > 0
    assert len(source.answers_at) >= 0.99 * len(source.sent), "nothing was lost"
