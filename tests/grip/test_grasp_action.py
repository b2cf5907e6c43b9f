"""Grasp and release of a virtual hand by the whole node, in simulated time."""

import math
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.clock import NS
from vegrip.errors import ConfigError, UsageError
from vegrip.grip.grasp_action import GraspAction, GraspGoal, ReleaseGoal, _look
from vegrip.grip.safety import LimitSettings
from vegrip.messages import Condition, FingertipState, ForceCommand, GraspPhase, GraspStatus
from vegrip.trials import candidates
from vegrip.trials.closed_loop import GRASPS
from vegrip.virtual import VirtualHand

PERIOD = 0.002  # [s]


class Bench:
    """A hand and a node that grips with it."""

    def __init__(self, *, silent=()):
        self.node = candidates.make_node(
            candidates.parameters("vegrip", candidates.KNOBS["pinch"]["vegrip"]), ("thumb", "index")
        )
        self.node.configure()
        self.node.activate()
        self.hand = VirtualHand(GRASPS["pinch"])
        self.hand.epoch = NS
        self.asked = dict.fromkeys(self.hand.fingers, math.nan)
        self.silent, self.statuses, self.most = set(silent), [], 0.0

    @property
    def phases(self):
        return [status.phase for status in self.statuses]

    def run(self, seconds, spoil=lambda state: state):
        end = self.hand.time + seconds
        while self.hand.time < end:
            samples = self.hand.advance(PERIOD, np.array(list(self.asked.values())))
            now = self.hand.epoch + round(self.hand.time * NS)
            states = [spoil(state) for sample in samples for state in sample.states(self.hand.fingers)]
            answers = [
                answer
                for state in states
                if state.finger not in self.silent
                for answer in self.node.on_message(state, now)
            ]
            for answer in (*answers, *self.node.on_tick(now)):
                if isinstance(answer, ForceCommand):
                    self.asked[answer.finger] = answer.normal_force
                    self.most = max(self.most, answer.normal_force)
                if isinstance(answer, GraspStatus):
                    self.statuses.append(answer)
        return self.statuses[-1] if self.statuses else None


def in_air(state: FingertipState) -> FingertipState:
    noise = 1e-3 * math.sin(state.seq**2)  # a live sensor is never still
    return replace(
        state,
        normal_force=noise,
        tangential_force_x=noise,
        tangential_force_y=-noise,
        torque_z=0.01 * noise,
        displacement=1e-3 * noise - 1e-3,
    )


def test_an_object_is_grasped_held_and_let_go_of():
    bench = Bench()
    bench.node.grasp({"force": 3.0})
    held = bench.run(2.0)
    assert bench.phases[:2] == [GraspPhase.CLOSING, GraspPhase.HELD]
    assert held.margin >= 0.0
    assert held.normal_force > 0.5
    assert not bench.hand.dropped
    bench.node.release({"rate": 10.0})
    before = max(bench.asked.values())
    bench.run(0.1)
    assert max(bench.asked.values()) == pytest.approx(before - 1.0, abs=0.4)  # slowly
    assert bench.run(2.0).phase is GraspPhase.RELEASED
    bench.node.parameters = replace(bench.node.parameters, report_period=0.03)  # does not close it again
    bench.run(0.5)
    assert set(bench.asked.values()) == {0.0}
    assert [status.seq for status in bench.statuses] == list(range(1, len(bench.statuses) + 1))


def test_without_a_goal_nothing_is_told_and_the_grip_is_as_before():
    plain, asked = Bench(), Bench()
    plain.run(1.0)
    asked.node.grasp({"force": 0.0})
    asked.run(1.0)
    assert plain.statuses == []
    assert plain.asked == asked.asked


def test_nothing_between_the_fingers_is_missed_with_the_reason():
    bench = Bench()
    bench.node.grasp({"force": 2.0, "timeout": 0.5})
    status = bench.run(1.2, in_air)
    assert status.phase is GraspPhase.MISSED
    assert status.reason == "thumb touches nothing"
    assert bench.run(1.5, in_air).reason == "thumb touches nothing"
    assert bench.node.grasp_status(0).phase is GraspPhase.MISSED


def test_an_object_that_is_taken_away_is_lost():
    bench = Bench()
    bench.node.grasp({"force": 3.0})
    assert bench.run(2.0).phase is GraspPhase.HELD
    status = bench.run(1.0, in_air)
    assert (status.phase, status.reason) == (GraspPhase.MISSED, "lost: thumb touches nothing")


def test_a_goal_below_what_holds_is_weak_and_its_force_is_never_exceeded():
    bench = Bench()
    bench.node.grasp({"force": 1.5, "max_force": 1.5, "margin": 0.9, "timeout": 1.0})
    status = bench.run(2.0)
    assert status.phase is GraspPhase.WEAK
    assert status.reason.startswith("margin of ")
    assert bench.most == 1.5


def test_a_finger_that_is_not_heard_is_named_and_the_hand_can_be_opened():
    bench = Bench()
    bench.node.grasp({"force": 2.0})
    assert bench.run(1.5).phase is GraspPhase.HELD
    bench.silent.add("index")
    assert bench.run(1.0).phase is GraspPhase.HELD  # no verdict by what is not heard
    assert bench.node.grasp_status(0).reason == "not judged: index stale"
    bench.node.release({})
    assert bench.run(3.0).phase is GraspPhase.RELEASED
    assert set(bench.asked.values()) == {0.0}


def test_a_hand_of_which_nothing_is_heard_is_not_said_to_be_open():
    bench = Bench(silent={"thumb", "index"})
    bench.node.release({"timeout": 0.5})
    bench.run(2.0)
    status = bench.node.grasp_status(0)
    assert status.phase is GraspPhase.RELEASING
    assert status.reason == "not judged: thumb missing, index missing"
    assert math.isnan(status.normal_force)
    bench.silent.clear()
    assert bench.run(2.0).phase is GraspPhase.RELEASED


def test_where_no_margin_is_known_force_decides_and_it_says_so():
    bench = Bench()
    bench.node.grasp({"force": 2.0})
    nan = math.nan
    status = bench.run(
        2.0, lambda one: replace(one, tangential_force_x=nan, tangential_force_y=nan, torque_z=nan)
    )
    assert status.phase is GraspPhase.HELD
    assert status.reason == "by force alone: no margin is known"
    assert math.isnan(status.margin)


def test_goals_have_these_defaults_and_bounds():
    declared = {
        GraspGoal: {
            "force": (2.0, 0.0, 1e3), "max_force": (1e3, 0.0, 1e3), "margin": (0.0, -1.0, 1.0),
            "timeout": (5.0, 0.1, 600.0),
        },
        ReleaseGoal: {"rate": (10.0, 0.1, 1e3), "timeout": (5.0, 0.1, 600.0)},
    }  # fmt: skip
    for goal, expected in declared.items():
        found = {f.name: (f.default, f.metadata["parameter"]) for f in fields(goal)}
        assert {name: (default, of.low, of.high) for name, (default, of) in found.items()} == expected


def test_goals_that_cannot_be_are_refused_in_a_sentence():
    bench = Bench()
    with pytest.raises(ConfigError, match="unknown key 'strength'"):
        bench.node.grasp({"strength": 2.0})
    with pytest.raises(ConfigError, match="margin"):
        bench.node.grasp({"margin": 2.0})
    bench.node.deactivate()
    with pytest.raises(UsageError, match="is not active"):
        bench.node.release({})


def finger(force, held, touches, bound, condition=Condition.OK):
    told = SimpleNamespace(contact=lambda _: SimpleNamespace(in_contact=touches))
    told.margin = lambda _: SimpleNamespace(lower_bound=bound)
    numbers = SimpleNamespace(felt=lambda: (force, 0.0))
    return SimpleNamespace(condition=condition, numbers=numbers, held=held, reports=told)


@pytest.mark.parametrize(
    ("force", "held", "touches", "limited", "soft", "largest"),
    [
        (4.0, 4.99, True, False, (), 4.0),
        (4.0, 5.0, True, True, (), 4.0),
        (4.0, 6.0, False, False, (), 4.0),  # only what touches counts
        (0.4, 4.0, True, False, ("index",), 1.0),
        (math.nan, 4.0, True, False, (), 1.0),
    ],
)
def test_a_look_finds_who_touches_who_is_at_the_limit_and_who_presses_too_little(
    force, held, touches, limited, soft, largest
):
    """Beside a thumb that presses with 1 N and holds 1 N, and a finger that is stale."""
    fingers = {
        "thumb": finger(1.0, 1.0, True, math.nan),
        "index": finger(force, held, touches, 0.3),
        "ring": finger(9.0, 9.0, True, 0.1, Condition.STALE),
    }
    found = _look(fingers, 0, 5.0)
    assert found.touching == (("thumb", "index") if touches else ("thumb",))
    assert (found.is_limited, found.soft, found.force) == (limited, soft, largest)
    assert found.bounds == ({"index": 0.3} if touches else {})
    assert found.faults == ("ring stale",)


def phases_of(action, fingers, seconds, start=7 * NS):
    """Look every 20 ms; return when each phase and reason came [ms]."""
    found, now = {}, start
    while now <= start + round(seconds * NS):
        action.look(fingers, now)
        found.setdefault((action.phase, action.reason), (now - start) // 1_000_000)
        now += NS // 50
    return found


CLOSED = {"touches": True, "force": 2.0, "held": 2.0, "bound": 0.1}


@pytest.mark.parametrize(
    ("change", "at_last", "reason", "ms"),
    [
        ({}, GraspPhase.HELD, "", 200),
        ({"bound": math.nextafter(0.1, 0.0)}, GraspPhase.WEAK, "margin of b above 0.10, not 0.1", 660),
        ({"bound": 0.0, "held": 5.0}, GraspPhase.WEAK, "margin of b above 0.00, not 0.1, at the limit", 200),
        ({"force": 1.6}, GraspPhase.HELD, "", 200),
        ({"force": 1.59}, GraspPhase.WEAK, "b presses less than it is asked to", 660),
        ({"touches": False}, GraspPhase.MISSED, "1 fingers touch", 660),
        ({"condition": Condition.DEGRADED}, GraspPhase.HELD, "", 200),
        ({"condition": Condition.STALE}, GraspPhase.WEAK, "not judged: b stale", 660),
    ],
)
def test_a_grasp_ends_when_its_verdict_has_stood_for_a_fifth_of_a_second(change, at_last, reason, ms):
    """It is asked for a bound of 0.1 and at most 5 N, within half a second; finger a has what is wanted.

    A verdict stands from the last look, every 20 ms, that said otherwise; late is what the next would be.
    """
    action = GraspAction("node", ("a", "b"))
    action.grasp(GraspGoal(force=2.0, max_force=5.0, margin=0.1, timeout=0.5))
    action.limits(LimitSettings())
    found = phases_of(action, {"a": finger(**CLOSED), "b": finger(**CLOSED | change)}, 1.5)
    assert (action.phase, action.reason) == (at_last, reason)
    assert found[at_last, reason] == ms
    assert {phase for phase, _ in found} == {GraspPhase.CLOSING, at_last}
    told = action.result(9 * NS)
    assert told.normal_force == 2.0  # of a at least
    assert told.margin == min(0.1, change.get("bound", 0.1))


@pytest.mark.parametrize(
    ("thumb", "touching", "at_last", "reason"),
    [
        ("", "ab", GraspPhase.HELD, ""),
        ("", "a", GraspPhase.MISSED, "1 fingers touch"),
        ("a", "bc", GraspPhase.MISSED, "a touches nothing"),
        ("a", "ac", GraspPhase.HELD, ""),
        ("none of this hand", "bc", GraspPhase.HELD, ""),
    ],
)
def test_of_three_fingers_two_are_a_grasp_with_the_thumb_among_them(thumb, touching, at_last, reason):
    action = GraspAction("node", tuple("abc"), thumb)
    action.grasp(GraspGoal(timeout=0.5))
    phases_of(action, {name: finger(**CLOSED | {"touches": name in touching}) for name in "abc"}, 1.0)
    assert (action.phase, action.reason) == (at_last, reason)


def test_a_goal_raises_the_least_force_while_it_closes_and_bounds_the_largest_until_the_next():
    """The hand is stated to press with 1 N at least and 20 N at most."""
    stated = LimitSettings(min_force=1.0, max_force=20.0)
    hand = {name: finger(**CLOSED) for name in "ab"}
    action = GraspAction("node", ("a", "b"))

    def kept():
        limits = action.limits(stated)
        return limits.min_force, limits.max_force

    assert kept() == (1.0, 20.0)
    action.grasp(GraspGoal(force=3.0, max_force=5.0))
    assert kept() == (3.0, 5.0)
    phases_of(action, hand, 1.0)
    assert (action.phase, kept()) == (GraspPhase.HELD, (1.0, 5.0))
    action.release(ReleaseGoal(rate=10.0), hand)
    assert kept() == (1.0, 2.0)  # from what it holds
    action.grasp(GraspGoal(force=30.0, max_force=30.0))
    assert kept() == (20.0, 20.0)
    action.grasp(GraspGoal(force=0.5))
    assert kept() == (1.0, 20.0)


@pytest.mark.parametrize(("held", "ms"), [(math.nan, 200), (0.0, 200), (0.9, 260), (1.9, 360)])
def test_a_release_takes_as_long_as_the_force_that_was_commanded_and_begins_at_once_without_one(held, ms):
    """Each look, every 20 ms, takes 0.2 N of it; it ends 0.2 s after the last look that left some."""
    hand = {"a": finger(0.0, held, False, math.nan), "b": finger(0.0, math.nan, False, math.nan)}
    action = GraspAction("node", ("a", "b"))
    action.release(ReleaseGoal(rate=10.0), hand)
    assert phases_of(action, hand, 1.0)[GraspPhase.RELEASED, ""] == ms


def test_of_a_hand_that_is_not_seen_no_force_is_told_and_a_long_reason_is_cut_to_64_letters():
    names = tuple(f"finger_{i}" for i in range(8))
    action = GraspAction("node", names)
    assert math.isnan(action.result(0).normal_force)  # nothing was looked at yet
    action.grasp(GraspGoal())
    action.look({name: finger(**CLOSED | {"condition": Condition.STALE}) for name in names}, NS)
    told = action.result(NS)
    assert math.isnan(told.normal_force)
    assert told.reason == ("not judged: " + ", ".join(f"{name} stale" for name in names))[:64]


@pytest.mark.parametrize(
    ("felt", "reason", "ms"),
    [(0.1, "", 560), (math.nextafter(0.1, 1.0), "0.1 N is felt", 1160), (0.7, "0.7 N is felt", 1160)],
)
def test_a_hand_is_open_once_nothing_is_asked_for_and_a_tenth_of_a_newton_is_felt_or_time_is_over(
    felt, reason, ms
):
    """It held 4 N and lets go with 10 N/s: the first look lowers, the last before zero is at 0.36 s."""
    hand = {"a": finger(felt, 4.0, False, math.nan), "b": finger(0.0, 1.0, False, math.nan)}
    action = GraspAction("node", ("a", "b"))
    action.release(ReleaseGoal(rate=10.0, timeout=1.0), hand)
    found = phases_of(action, hand, 2.0)
    assert found[GraspPhase.RELEASED, reason] == ms
    still = [said for phase, said in found if phase is GraspPhase.RELEASING and said]
    assert still == ([f"{felt:.1f} N is still felt"] if reason else [])


def test_a_phase_is_told_at_once_and_then_every_second():
    action = GraspAction("node", ("a", "b"))
    assert action.status(0) is None
    action.grasp(GraspGoal(timeout=600.0))
    nothing = {name: finger(0.0, 0.0, False, math.nan) for name in "ab"}
    told = []
    for ms in range(0, 3000, 10):
        action.look(nothing, ms * 1_000_000)
        if status := action.status(ms * 1_000_000):
            told.append((ms, status.seq, status.phase, status.reason))
    closing = GraspPhase.CLOSING, "0 fingers touch"
    assert told == [(0, 1, *closing), (1000, 2, *closing), (2000, 3, *closing)]


def test_the_limits_may_be_others_after_each_look_that_was_due_and_not_between_two():
    hand = {name: finger(0.0, 0.0, False, math.nan) for name in "ab"}
    action = GraspAction("node", ("a", "b"))
    assert not action.look(hand, 0)
    action.grasp(GraspGoal())
    assert [ms for ms in range(0, 61, 5) if action.look(hand, ms * 1_000_000)] == [0, 20, 40, 60]


def test_a_hand_of_one_finger_holds_what_that_finger_touches():
    for touches, last in ((True, (GraspPhase.HELD, "")), (False, (GraspPhase.MISSED, "0 fingers touch"))):
        action = GraspAction("node", ("a",))
        action.grasp(GraspGoal(timeout=0.5))
        phases_of(action, {"a": finger(**CLOSED | {"touches": touches})}, 1.0)
        assert (action.phase, action.reason) == last


@pytest.mark.parametrize("held", [(math.nan, 3.0, 1.0), (1.0, math.nan, 3.0), (3.0, 1.0, math.nan)])
def test_a_release_begins_at_the_largest_force_that_is_known(held):
    action = GraspAction("node", tuple("abc"))
    hand = {name: finger(0.0, one, False, math.nan) for name, one in zip("abc", held, strict=True)}
    action.release(ReleaseGoal(), hand)
    assert action.limits(LimitSettings(max_force=20.0)).max_force == 3.0


def test_a_grasp_that_is_held_stays_so_while_a_finger_presses_less_than_it_is_asked_to():
    """Less counts while it closes: what is held may be let go of a little, as its margin allows."""
    action = GraspAction("node", ("a", "b"))
    action.grasp(GraspGoal(timeout=0.5))
    hand = {name: finger(**CLOSED) for name in "ab"}
    phases_of(action, hand, 1.0)
    assert action.phase is GraspPhase.HELD
    hand["b"] = finger(**CLOSED | {"force": 0.5})
    found = phases_of(action, hand, 2.0, 9 * NS)
    assert list(found) == [(GraspPhase.HELD, "")]
