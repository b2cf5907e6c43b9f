"""Laws of the loop, on a simulated clock and without any bus."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from tests.pair import PairEndpoint, pair
from vegrip.clock import NS, SimulatedClock
from vegrip.errors import UsageError
from vegrip.messages import FingertipState, ForceCommand, Lifecycle, ModelHealth, NodeStatus, Reason
from vegrip.runtime import NodeBase
from vegrip.runtime.runner import LoopSettings, Runner

MS = 1_000_000


class Follower(NodeBase):
    """Answers each state with a command of twice its force and notes when it ticks."""

    def __init__(self, clock, cost=0.0):
        super().__init__("follower")
        self.clock, self.cost = clock, cost
        self.ticks, self.heard, self.broken, self.activations = [], [], False, 0

    def activate(self):
        self.activations += 1

    def on_message(self, message, now):
        self.heard.append(message)
        if self.broken:
            raise ZeroDivisionError("a mistake in the node")
        self.clock.advance(self.cost)
        if isinstance(message, FingertipState):
            yield ForceCommand(
                now, message.finger, message.seq, 2 * message.normal_force, 0.0, Reason.HOLD, now + 50 * MS
            )

    def on_tick(self, now):
        self.ticks.append(now)
        return ()


class Rig:
    def __init__(self, cost=0.0, **settings):
        self.clock = SimulatedClock(start=7 * NS)
        endpoint, self.outside = pair(self.clock)
        self.node = Follower(self.clock, cost)
        self.runner = Runner(self.node, endpoint, self.clock, LoopSettings(**settings))

    def state(self, seq=0, force=1.5, finger="thumb"):
        self.outside.send(FingertipState(self.clock.now(), finger, seq, normal_force=force))

    def answers(self, kind=ForceCommand):
        return [message for message in self.outside.receive(0.0) if isinstance(message, kind)]

    def steps(self, count):
        for _ in range(count):
            self.runner.step()


@pytest.fixture
def rig():
    rig = Rig()
    rig.runner.start()
    rig.runner.step()  # the tick that is due at once
    return rig


def test_a_state_is_answered_in_the_step_that_receives_it(rig):
    rig.state(force=1.5)
    rig.runner.step()
    assert [command.normal_force for command in rig.answers()] == [3.0]


class Talker(Follower):
    """Reports after each command, which takes its time."""

    def on_message(self, message, now):
        yield from super().on_message(message, now)
        self.clock.advance(0.001)
        yield ModelHealth(self.clock.now(), message.finger, message.seq)


def test_no_command_waits_for_the_report_of_another_finger():
    rig = Rig()
    rig.runner.managed.node = Talker(rig.clock)
    rig.runner.start()
    rig.runner.step()
    for finger in ("thumb", "index", "middle"):
        rig.state(finger=finger)
    rig.runner.step()
    kinds = [type(message) for message in rig.answers((ForceCommand, ModelHealth))]
    assert kinds == [ForceCommand] * 3 + [ModelHealth] * 3
    assert rig.runner.statistics.latency.maximum == 0


def test_a_state_that_comes_during_the_reports_is_answered_before_the_next_report():
    rig = Rig()
    node = rig.runner.managed.node = Talker(rig.clock)
    rig.runner.start()
    rig.runner.step()
    for finger in ("thumb", "index"):
        rig.state(finger=finger)
    say, late = node.on_message, iter(["middle"])

    def answer(message, now):
        for told in say(message, now):
            if isinstance(told, ModelHealth):
                for finger in late:
                    rig.state(finger=finger)  # while the first report is worked out
            yield told

    node.on_message = answer
    rig.runner.step()
    told = [(type(message).__name__, message.finger) for message in rig.answers((ForceCommand, ModelHealth))]
    assert told[:2] == [("ForceCommand", "thumb"), ("ForceCommand", "index")]
    assert told[2:4] == [("ModelHealth", "thumb"), ("ForceCommand", "middle")]
    assert sorted(told[4:]) == [("ModelHealth", "index"), ("ModelHealth", "middle")]


class Numbering(Follower):
    """Reports in two parts, after each command and in each tick; it numbers them as it makes them."""

    reports = 0

    def parts(self, finger):
        first = self.reports
        self.reports += 2
        self.clock.advance(0.02)  # so that a tick is due before the second part is sent
        yield ModelHealth(self.clock.now(), finger, first)
        yield ModelHealth(self.clock.now(), finger, first + 1)

    def on_message(self, message, now):
        if message.normal_force > 0.0:
            yield from super().on_message(message, now)
        yield from self.parts(message.finger)

    def on_tick(self, now):
        super().on_tick(now)
        command = ForceCommand(now, "index", len(self.ticks), 1.0, 0.0, Reason.HOLD, now + 50 * MS)
        return [*self.parts("thumb"), command]


@pytest.mark.parametrize("force", [1.5, 0.0], ids=["commanded", "not commanded"])
def test_what_a_tick_tells_does_not_overtake_a_report_of_two_parts(force):
    rig = Rig()
    rig.runner.managed.node = Numbering(rig.clock)
    rig.runner.start()
    rig.state(seq=0, force=1.5)
    rig.state(seq=1, force=force)
    rig.steps(3)
    told = [message.seq for message in rig.answers(ModelHealth)]
    assert len(told) >= 6
    assert told == sorted(told)


def test_what_a_node_that_fails_in_its_report_had_commanded_has_been_sent(rig):
    def answer(message, now):
        yield from Follower.on_message(rig.node, message, now)
        raise ZeroDivisionError("a mistake in the report")

    rig.node.on_message = answer
    rig.state(force=1.5)
    rig.runner.step()
    assert rig.answers()[0].normal_force == 3.0
    assert rig.runner.state is Lifecycle.INACTIVE
    assert rig.runner.managed.faults == {"fault ZeroDivisionError": 1}


def test_messages_before_activation_are_not_processed():
    rig = Rig()
    rig.state(seq=1)
    rig.runner.change("configure")
    rig.state(seq=2)
    rig.steps(3)  # received while inactive
    rig.state(seq=3)  # still in the queue when the node turns active
    rig.runner.change("activate")
    rig.state(seq=4)
    rig.steps(3)
    assert [message.seq for message in rig.node.heard] == [4]


def test_nothing_is_answered_after_deactivation(rig):
    rig.runner.change("deactivate")
    rig.state()
    rig.steps(3)
    assert rig.answers() == []
    assert rig.runner.statistics.states == 0


def test_two_hands_in_turn_are_counted_in_the_status(rig):
    for seq in range(400):
        rig.state(seq, force=5.0 if seq % 2 else 2.0)
        rig.runner.step()
    rig.steps(600)
    counts = rig.answers(NodeStatus)[-1].rejected
    assert counts["two_senders"] > 300


def test_the_tick_grid_never_drifts_after_a_late_tick(rig):
    rig.steps(4)
    start = rig.node.ticks[0]
    rig.clock.advance(0.0075)  # the machine was busy elsewhere
    rig.steps(6)
    late = rig.node.ticks[5]
    assert (late - start) % (2 * MS) != 0
    assert all((tick - start) % (2 * MS) == 0 for tick in rig.node.ticks[6:])
    assert rig.runner.schedule.skipped == 2


def test_lateness_and_missed_deadlines_are_reported():
    rig = Rig(tick_period=0.002, status_period=0.1, deadline=0.005)
    rig.runner.start()
    rig.runner.step()
    rig.clock.advance(0.0195)
    rig.steps(120)
    status = rig.answers(NodeStatus)
    assert max(message.lateness_max for message in status) == pytest.approx(17_500)  # [us]
    assert status[-1].deadline_misses == 1
    assert status[-1].lateness_max == 0.0, "each status speaks of its own period"


def test_latency_runs_from_the_arrival_to_the_command_and_includes_waiting_behind_others():
    rig = Rig(cost=0.001, status_period=0.1)
    rig.runner.start()
    rig.runner.step()
    for finger in ("thumb", "index", "middle"):
        rig.state(finger=finger)
    rig.runner.step()
    latency = rig.runner.statistics.latency
    assert latency.count == 3
    assert latency.maximum == 3 * MS
    assert latency.percentile(0.5) == pytest.approx(2 * MS, rel=1 / 32)


def test_status_has_the_rates_of_its_period(rig):
    rig.answers(NodeStatus)
    for seq in range(500):
        rig.state(seq)
        rig.runner.step()
    rig.steps(600)
    statuses = rig.answers(NodeStatus)
    total = sum(message.rate_in for message in statuses)
    assert total == pytest.approx(500, rel=0.01)  # periods of one second
    assert [message.seq for message in statuses] == list(range(statuses[0].seq, statuses[-1].seq + 1))
    assert statuses[-1].state is Lifecycle.ACTIVE


def test_an_exception_puts_the_node_on_hold_and_the_last_command_goes_on(rig):
    rig.state(seq=5, force=1.5)
    rig.runner.step()
    before = rig.answers()[0]
    rig.node.broken = True
    rig.state(seq=6)
    rig.runner.step()  # the fault
    rig.steps(150)  # 0.3 s
    held = rig.answers()
    assert rig.runner.state is Lifecycle.INACTIVE
    assert len(held) == 11, "renewed when half their life of 50 ms has gone, on a tick"
    assert all(after.stamp < before.expires for before, after in pairwise([before, *held]))
    assert {command.normal_force for command in held} == {before.normal_force}
    assert {command.reason for command in held} == {Reason.INPUT_HOLD}
    assert [command.seq for command in held] == list(range(before.seq + 1, before.seq + 12))
    assert all(command.expires - command.stamp == 50 * MS for command in held)


def test_a_node_speaks_for_itself_while_on_hold(rig):
    own = ForceCommand(rig.clock.now(), "thumb", 1, 9.0, 0.0, Reason.FAIL_SAFE, rig.clock.now() + NS)
    rig.node.on_fault = lambda _now: [own]
    rig.node.broken = True
    rig.state()
    rig.steps(1 + 3)
    assert rig.answers() == [replace(own, seq=seq) for seq in (1, 2, 3)]


def test_commands_are_held_even_when_the_fault_handler_fails_too(rig):
    rig.state()
    rig.runner.step()
    rig.answers()
    rig.node.on_fault = lambda _now: 1 / 0
    rig.node.broken = True
    rig.state()
    rig.steps(1 + 50)
    assert [command.reason for command in rig.answers()] == [Reason.INPUT_HOLD] * 3


def test_faults_are_counted_by_name_in_the_status(rig):
    rig.node.broken = True
    rig.state()
    rig.steps(600)
    assert rig.answers(NodeStatus)[-1].rejected["fault ZeroDivisionError"] == 1


def test_a_node_on_hold_is_activated_again_after_a_back_off_that_doubles(rig):
    rig.node.broken = True
    failures = []
    for _ in range(3):
        rig.state()
        rig.runner.step()
        failures.append(rig.clock.now())
        while rig.runner.state is not Lifecycle.ACTIVE:
            rig.runner.step()
        failures[-1] = (rig.clock.now() - failures[-1]) / NS
    assert failures == pytest.approx([1.0, 2.0, 4.0], abs=0.01)
    assert rig.node.activations == 4
    rig.node.broken = False
    rig.state(force=2.0)
    rig.runner.step()
    assert rig.answers()[-1].normal_force == 4.0


def test_numbers_of_commands_never_run_backwards_over_a_fault(rig):
    for broken in (False, True, False):
        rig.node.broken = broken
        rig.state(seq=0)  # the node counts from zero again when it begins afresh
        rig.steps(600)
    numbers = [command.seq for command in rig.answers()]
    assert len(numbers) > 40
    assert numbers == list(range(len(numbers)))


def test_a_refused_transition_changes_nothing(rig):
    with pytest.raises(UsageError):
        rig.runner.change("configure")
    assert rig.runner.state is Lifecycle.ACTIVE


def test_a_node_that_cannot_configure_stays_unconfigured():
    rig = Rig()
    rig.node.configure = lambda: 1 / 0
    with pytest.raises(ZeroDivisionError):
        rig.runner.start()
    assert rig.runner.state is Lifecycle.UNCONFIGURED


def test_run_ends_when_the_node_has_finished_and_shuts_it_down(rig):
    calls = []
    rig.node.deactivate = lambda: calls.append("deactivate")
    rig.node.cleanup = lambda: calls.append("cleanup")
    rig.node.on_tick = lambda now: setattr(rig.node, "finished", now > 8 * NS) or ()
    rig.runner.run()
    assert calls == ["deactivate", "cleanup"]
    assert rig.answers(NodeStatus)[-1].state is Lifecycle.FINALIZED


def test_stop_ends_the_loop(rig):
    rig.node.on_tick = lambda _now: rig.runner.stop() or ()
    rig.runner.run()
    assert rig.runner.state is Lifecycle.FINALIZED


def test_requests_of_other_threads_are_served_between_messages(rig):
    future = rig.runner.inbox.put(lambda: rig.runner.change("deactivate"))
    refused = rig.runner.inbox.put(lambda: rig.runner.change("configure"))
    rig.runner.step()
    assert future.result(timeout=0) is None
    assert isinstance(refused.exception(timeout=0), UsageError)
    assert rig.runner.state is Lifecycle.INACTIVE


def test_without_states_latency_is_not_a_number(rig):
    rig.steps(600)
    assert math.isnan(rig.answers(NodeStatus)[-1].latency_p99)


def test_what_passed_by_before_the_activation_is_not_lost(rig):
    endpoint = rig.runner._endpoint
    rig.runner.change("deactivate")
    endpoint.rejected["lost"] = 6000
    rig.runner.change("activate")
    rig.clock.advance(1.0)
    rig.runner.step()
    assert "lost" not in rig.runner.status.rejected
    endpoint.rejected["lost"] += 2
    rig.clock.advance(1.0)
    rig.runner.step()
    assert rig.runner.status.rejected["lost"] == 2


class Inspector(Follower):
    def __init__(self, clock):
        super().__init__(clock)
        self.told = []

    def on_broken(self, finger, now):
        self.told.append((finger, now))


def test_a_node_is_told_once_for_each_look_at_the_bus_whose_states_came_broken(monkeypatch):
    clock = SimulatedClock(start=7 * NS)
    endpoint, _ = pair(clock)
    monkeypatch.setattr(type(endpoint), "broken", {})
    runner = Runner(Inspector(clock), endpoint, clock)
    endpoint.broken["thumb"] = 3
    runner.step()
    assert runner.managed.node.told == [], "it is not active"
    runner.start()
    endpoint.broken.update(thumb=5, index=1)
    runner.step()
    runner.step()
    assert [finger for finger, _ in runner.managed.node.told] == ["thumb", "index"]


def test_an_endpoint_that_tells_nothing_of_broken_states_will_do():
    rig = Rig()
    rig.runner.start()
    rig.steps(3)
    assert rig.runner.state is Lifecycle.ACTIVE


class Hand(NodeBase):
    """Sends a state at every tick, and hears commands."""

    def on_tick(self, now):
        return [FingertipState(now, "thumb", 0, normal_force=1.0)]


def test_a_hand_tells_the_rates_of_its_commands_and_states():
    clock = SimulatedClock(start=7 * NS)
    endpoint, outside = pair(clock)
    runner = Runner(Hand("hand"), endpoint, clock, LoopSettings(tick_period=0.002))
    runner.start()
    for i in range(2000):
        if i % 5 == 0:
            outside.send(ForceCommand(clock.now(), "thumb", i, 1.0, 0.0, Reason.HOLD, clock.now() + NS))
        runner.step()
    assert runner.status.rate_out == pytest.approx(500.0, rel=0.05)
    assert 50.0 < runner.status.rate_in < runner.status.rate_out


@pytest.mark.parametrize("transition", ["deactivate", "shutdown"])
def test_a_change_of_state_is_told_at_once_not_at_the_next_period(rig, transition):
    rig.steps(3)
    rig.answers(NodeStatus)
    before = rig.clock.now()
    rig.runner.change(transition)
    rig.runner.step()
    (status,) = rig.answers(NodeStatus)
    assert status.state in (Lifecycle.INACTIVE, Lifecycle.FINALIZED)
    assert status.stamp - before < 10 * MS


class RecordedPriority:
    def __init__(self):
        self.heard = []

    def take(self):
        self.heard.append("take")
        return "real-time priority is not permitted"

    def give_back(self):
        self.heard.append("give back")


def test_the_loop_has_its_priority_while_the_node_is_active_only_and_says_once_what_is_not_permitted(caplog):
    priority, clock = RecordedPriority(), SimulatedClock()
    endpoint, _ = pair(clock)
    runner = Runner(Follower(clock), endpoint, clock, priority=priority)
    runner.change("configure")
    assert "take" not in priority.heard, "to configure is to compile"
    runner.change("activate")
    assert priority.heard[-1] == "take"
    runner.change("deactivate")
    assert priority.heard[-1] == "give back"
    assert caplog.text.count("not permitted") == 1


def told(rig, count):
    """Answer ``count`` states, one every 10 ms, and return how many commands and reports came of them."""
    commands = reports = 0
    for seq in range(count):
        rig.state(seq=seq)
        rig.runner.step()
        answers = rig.answers((ForceCommand, ModelHealth))
        commands += sum(isinstance(answer, ForceCommand) for answer in answers)
        reports += sum(isinstance(answer, ModelHealth) for answer in answers)
        rig.clock.advance(0.010)
    return commands, reports


def test_a_machine_that_cannot_keep_up_lowers_the_rate_of_reports_never_of_commands_and_says_so_once(caplog):
    rig = Rig(deadline=0.010)
    node = rig.runner.managed.node = Talker(rig.clock)
    rig.runner.start()
    assert told(rig, 100) == (100, 100)
    node.cost = 0.008  # [s] for each command
    told(rig, 100)
    commands, reports = told(rig, 1000)
    seconds = 1000 * (0.010 + 0.008)  # and a few reports
    assert commands == 1000
    assert 0.8 * 5 * seconds < reports <= 1.2 * 5 * seconds
    assert rig.runner.status.rejected["reports_lowered"] == 1
    assert caplog.text.count("cannot keep up") == 1
    node.cost = 0.0
    told(rig, 1500)
    assert told(rig, 100) == (100, 100)


def test_troubles_that_begin_together_are_all_said_in_one_record_since_one_passes_a_second(
    monkeypatch, caplog
):
    rig = Rig(status_period=0.1)
    hints = {"lost_left": "left is silent", "lost_right": "right is silent"}
    monkeypatch.setattr(PairEndpoint, "hints", hints, raising=False)
    monkeypatch.setattr(PairEndpoint, "rejected", dict.fromkeys(hints, 1), raising=False)
    rig.runner.start()
    end = rig.clock.now() + NS // 2
    while rig.clock.now() < end:
        rig.runner.step()
    said = [each.getMessage() for each in caplog.records if "silent" in each.message]
    assert said == ["left is silent\nright is silent"]


def test_a_fault_of_a_device_is_said_once_as_it_begins_and_once_as_it_ends(monkeypatch, caplog):
    rig = Rig(status_period=0.1)
    said, told = set(), [("gripper", "object_lost"), ("gripper", "too_hot")]
    monkeypatch.setattr(PairEndpoint, "device_faults", property(lambda _: said), raising=False)
    caplog.set_level("INFO", "vegrip.follower")
    rig.runner.start()

    def lines():
        caplog.clear()
        end = rig.clock.now() + NS // 2  # several reports
        while rig.clock.now() < end:
            rig.runner.step()
        return [(each.levelname, each.getMessage()) for each in caplog.records if "gripper" in each.message]

    assert lines() == []
    said.update(told)
    assert lines() == [("WARNING", "gripper says of itself: object lost; gripper says of itself: too hot")]
    said.discard(told[1])
    assert lines() == [("INFO", "gripper no longer says: too hot")]
    said.discard(told[0])
    assert lines() == [("INFO", "gripper no longer says: object lost")]
    said.add(told[0])
    assert lines() == [("WARNING", "gripper says of itself: object lost")]


def test_a_part_that_comes_back_is_no_error_and_when_it_goes_again_within_a_minute_that_is_news(
    monkeypatch, caplog
):
    rig = Rig(status_period=0.1)
    counts = {}
    monkeypatch.setattr(PairEndpoint, "rejected", property(lambda _: counts), raising=False)
    hints = {
        "lost_left": "left is silent",
        "back_left": "left is received again",
        "uneven_jaws": "left feels more",
    }
    monkeypatch.setattr(PairEndpoint, "hints", hints, raising=False)
    caplog.set_level("INFO", "vegrip.follower")
    rig.runner.start()
    for name in ("lost_left", "back_left", "lost_left", "back_left"):
        for _ in range(3):  # counted again and again, and said once
            counts[name] = counts.get(name, 0) + 1
            end = rig.clock.now() + NS // 5
            while rig.clock.now() < end:
                rig.runner.step()
    said = [(each.levelname, each.getMessage()) for each in caplog.records if "left" in each.message]
    assert said == 2 * [("ERROR", "left is silent"), ("INFO", "left is received again")]
    caplog.clear()
    counts |= {"lost_left": 99, "back_left": 99, "uneven_jaws": 1}
    rig.clock.advance(0.2)
    rig.runner.step()
    assert [each.levelname for each in caplog.records] == ["ERROR", "WARNING", "INFO"]
