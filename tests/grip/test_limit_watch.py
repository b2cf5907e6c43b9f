"""Laws of the largest force: said where it stops the grip, and before, and only once."""

import dataclasses
import logging
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from vegrip.nodes.grasp_force import build

from tests.grip.conftest import ConeEstimator
from vegrip.grip.controller import GripController
from vegrip.grip.limit_watch import LimitWatch, against_thumb
from vegrip.grip.node import GraspForce
from vegrip.grip.safety import LimitSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Condition, FingertipState, ForceCommand, ModelHealth, Reason
from vegrip.runtime import NodeContext

MakeNode = Callable[..., GraspForce]
MakeState = Callable[..., FingertipState]
PERIOD = 2_000_000  # [ns]
MU = 0.8  # of the estimator of these tests
ALONE = ControlSettings(thumb="", limits=LimitSettings(max_force=10.0))
WANTED = MU * (1.0 - ALONE.grip.wanted_margin)  # load over the need


@dataclasses.dataclass
class Play:
    """States of one finger go in, what is told comes out."""

    node: GraspForce
    state: MakeState
    count: int = 0

    def run(
        self, seconds: float, load: Callable[[float], float], *, touches: bool = True
    ) -> list[ModelHealth]:
        told, begin = [], self.count
        for _ in range(round(seconds * 500)):
            self.count += 1
            x = load((self.count - begin) / 500)
            now, force = self.count * PERIOD, 3.0 * touches + 1e-3 * math.sin(self.count)
            state = self.state(self.count, tangential_force_x=x, normal_force=force)
            told += self.node.on_message(state, now)
            told += self.node.on_tick(now)
        self.commands = [one for one in told if isinstance(one, ForceCommand)]
        return [one for one in told if isinstance(one, ModelHealth)]


@pytest.fixture
def play(make_node: MakeNode, state: MakeState) -> Play:
    return Play(make_node(settings=ALONE), state)


def steady(need: float) -> Callable[[float], float]:
    return lambda _: WANTED * need


def warnings(log: pytest.LogCaptureFixture) -> list[str]:
    return [one.getMessage() for one in log.records if one.levelno >= logging.WARNING]


@pytest.mark.parametrize(
    ("need", "said"),
    [(3.0, ""), (6.5, ""), (6.8, "near"), (9.9, "near"), (10.1, "reached"), (30.0, "reached")],
)
def test_a_load_half_as_large_again_is_looked_ahead_to(play: Play, need: float, said: str) -> None:
    assert play.run(2.0, steady(need))[-1].limit == said


@pytest.mark.parametrize(("torque", "said"), [(0.014, ""), (0.024, "near"), (math.nan, "")])
def test_half_as_much_torque_again_is_looked_ahead_to_as_well(
    play: Play, monkeypatch: pytest.MonkeyPatch, torque: float, said: str
) -> None:
    """Needed are 3 N for the force and 200 N for each N m: half as much again is 10 N at 0.0183 N m."""

    def least(self: ConeEstimator, _margin: float, _confidence: float, load: tuple[float, float]) -> float:
        return 3.0 / (2.0 * WANTED) * load[0] + 200.0 * load[1]

    monkeypatch.setattr(ConeEstimator, "least_force", least)
    given = play.state
    play.state = lambda count, **values: given(count, torque_z=torque, **values)
    assert play.run(1.0, steady(2.0))[-1].limit == said


def test_what_is_reached_is_said_in_command_health_and_log(
    play: Play, caplog: pytest.LogCaptureFixture
) -> None:
    last = play.run(2.0, steady(12.0))[-1]
    assert last.limit == "reached"
    assert (play.commands[-1].reason, play.commands[-1].normal_force) == (Reason.MAX_LIMIT, 10.0)
    assert warnings(caplog)[-1] == "index: limits.max_force (10 N) stops the grip: 12 N are needed"


def test_it_is_said_before_the_limit_is_reached(play: Play, caplog: pytest.LogCaptureFixture) -> None:
    healths = play.run(14.0, lambda t: WANTED * (2.0 + 0.8 * t))
    seen = list(dict.fromkeys(one.limit for one in healths))
    assert seen == ["", "near", "reached"]
    first = {state: next(one.stamp for one in healths if one.limit == state) for state in seen}
    assert (first["reached"] - first["near"]) / 1e9 > 3.0
    said = warnings(caplog)
    assert len(said) == 2
    assert said[0].startswith("index: limits.max_force (10 N) may stop the grip: ")


def test_what_comes_and_goes_is_said_once_and_its_end_too(
    play: Play, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    play.run(6.0, lambda t: WANTED * (8.0 if t % 1.0 < 0.5 else 4.0))
    assert len(warnings(caplog)) == 1
    assert play.run(8.0, steady(2.0))[-1].limit == ""
    assert caplog.records[-1].getMessage() == "index: limits.max_force (10 N) suffices again"


def test_a_load_that_no_force_carries_is_said_so(play: Play, caplog: pytest.LogCaptureFixture) -> None:
    play.run(1.0, steady(3.0))
    play.node.fingers["index"].estimator.least_force = lambda *_: math.inf  # type: ignore[method-assign]
    assert play.run(2.0, steady(3.0))[-1].limit == "reached"
    assert warnings(caplog)[-1].endswith("stops the grip: no force suffices")


def test_a_finger_in_the_air_or_unheard_says_nothing(play: Play) -> None:
    assert play.run(1.0, steady(0.0), touches=False)[-1].limit == ""
    play.run(1.0, steady(9.0))
    assert play.run(3.0, steady(9.0), touches=False)[-1].limit == ""


@pytest.mark.parametrize(
    ("condition", "is_trusted", "said"),
    [
        (Condition.OK, True, "near"),
        (Condition.DEGRADED, True, "near"),
        (Condition.OK, False, ""),
        (Condition.STALE, True, ""),
    ],
)
def test_a_need_counts_of_a_finger_that_is_heard_and_whose_estimate_is_trusted(
    condition: Condition, is_trusted: bool, said: str
) -> None:
    held = SimpleNamespace(reason=Reason.HOLD)
    memory = {"NEED_TRUSTED": is_trusted, "NEED_IN_CONTACT": 0, "DEMAND_LEAST": 20.0}
    finger: Any = SimpleNamespace(
        condition=condition, started=True, memory=memory, command=lambda: held, standing_command=lambda: held
    )
    limit = LimitWatch(lambda needs: needs)
    limit.look({"index": finger}, 10.0, 0)
    assert limit.state("index") == said


def test_letting_go_on_purpose_is_no_limit_of_the_grip(play: Play, caplog: pytest.LogCaptureFixture) -> None:
    play.run(1.0, steady(4.0))
    play.node.release({"rate": 5.0})
    assert play.run(4.0, steady(4.0))[-1].limit == ""
    assert warnings(caplog) == []


def test_the_thumb_is_looked_at_with_what_the_others_press(make_node: MakeNode, state: MakeState) -> None:
    settings = ControlSettings(limits=LimitSettings(max_force=10.0))
    node = make_node(("thumb", "index", "middle"), settings)
    told = []
    for count in range(1, 1000):
        for finger, need in (("thumb", 1.0), ("index", 4.0), ("middle", 4.0)):
            told += node.on_message(state(count, finger, tangential_force_x=WANTED * need), count * PERIOD)
    last = {one.finger: one.limit for one in told if isinstance(one, ModelHealth)}
    assert last == {"thumb": "near", "index": "", "middle": ""}


@pytest.mark.parametrize(
    ("needs", "shares"),
    [
        ({"thumb": 1.0, "index": 2.0, "middle": 3.0}, {"thumb": 5.0, "index": 2.0, "middle": 3.0}),
        ({"thumb": 9.0, "index": 2.0, "middle": 1.0}, {"thumb": 9.0, "index": 6.0, "middle": 3.0}),
        ({"index": 2.0, "middle": 3.0}, {"index": 2.0, "middle": 3.0}),
        ({"thumb": 2.0, "index": 0.0}, {"thumb": 2.0, "index": 0.0}),
    ],
)
def test_the_thumb_carries_what_the_others_press(needs: dict[str, float], shares: dict[str, float]) -> None:
    assert against_thumb(needs, "thumb") == pytest.approx(shares)


UNSTATED = "limits.max_force is 15 N because none is stated: state what fingers and object bear"


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (None, [UNSTATED]),
        (ControlSettings(thumb=""), [UNSTATED]),
        (ControlSettings(limits=LimitSettings(max_force=15.0)), []),
        (ControlSettings(limits=LimitSettings(max_force=8.0)), []),
    ],
)
def test_a_limit_that_nobody_stated_is_said_once_by_a_controller_in_use(
    caplog: pytest.LogCaptureFixture, settings: ControlSettings | None, said: list[str]
) -> None:
    hand = GripController(("index",), settings=settings, make_estimator=ConeEstimator)
    for count in range(1, 4):
        hand.step([], count * PERIOD)
    assert warnings(caplog) == said
    assert hand.settings.limits.max_force == (8.0 if settings and settings.limits.max_force == 8.0 else 15.0)


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({}, [f"{UNSTATED}, in the launch file or in [limits] of a map"]),
        ({"limits": {"max_force": 15.0}}, []),
    ],
)
def test_a_limit_that_nobody_stated_is_said_once_by_a_node(
    caplog: pytest.LogCaptureFixture, stated: dict[str, object], said: list[str]
) -> None:
    node = build({**stated, "suspects": False}, NodeContext("/grasp", "", ("index",)))
    node.configure()
    node.activate()
    assert warnings(caplog) == said


def test_a_controller_without_a_node_foresees_too() -> None:
    hand = GripController(("index",), settings=ALONE, make_estimator=ConeEstimator)
    for count in range(1, 500):
        values = {"normal_force": 3.0 + 1e-3 * math.sin(count), "tangential_force_x": 8.0 * WANTED}
        state = FingertipState(
            count * PERIOD, "index", count, **values, tangential_force_y=0.0, displacement=1e-3
        )
        hand.step([state], count * PERIOD)
    assert hand.health("index").limit == "near"


def stand_in(least: float = 7.0, growth: float = 1.5, **changes: Any) -> Any:
    """Return a finger that needs ``least`` [N], and ``growth`` times that for half as much load again."""
    held, asked = SimpleNamespace(reason=Reason.HOLD), list[tuple[float, float]]()
    memory = {
        "NEED_TRUSTED": 1, "NEED_IN_CONTACT": 1, "DEMAND_LEAST": least, "DEMAND_LOAD": 2.0,
        "DEMAND_TORQUE": 0.01, "ASKED_MARGIN": 0.2, "ASKED_QUANTILE": 1.645,
    }  # fmt: skip

    def least_force(margin: float, confidence: float, load: tuple[float, float]) -> float:
        assert (margin, confidence) == (0.2, pytest.approx(0.95, abs=1e-3))
        asked.append(load)
        return least if len(asked) % 2 else growth * least

    values = {
        "condition": Condition.OK, "started": True, "memory": memory, "command": lambda: held,
        "standing_command": lambda: held, "estimator": SimpleNamespace(least_force=least_force),
        "asked": asked,
    }  # fmt: skip
    return SimpleNamespace(**values | changes)


def needs_as_they_are(needs: Any) -> Any:
    return needs


S = 1_000_000_000  # [ns]


@pytest.mark.parametrize(
    ("later", "said"), [(1.9, "near"), (2.0 - 1e-9, "near"), (2.0, ""), (2.2, ""), (-1e-9, ""), (-99.0, "")]
)
def test_what_is_near_is_said_for_two_seconds_after_its_cause_and_not_over_a_clock_set_back(
    later: float, said: str
) -> None:
    watch = LimitWatch(needs_as_they_are)
    watch.look({"index": stand_in(7.0)}, 10.0, 100 * S)
    assert watch.state("index") == "near"
    watch.look({"index": stand_in(2.0)}, 10.0, 100 * S + round(later * S))
    assert watch.state("index") == said


def test_a_clock_that_was_set_back_does_not_end_the_looks() -> None:
    watch = LimitWatch(needs_as_they_are)
    watch.look({"index": stand_in(2.0)}, 10.0, 100 * S)
    watch.look({"index": stand_in(7.0)}, 10.0, S)
    assert watch.state("index") == "near"


def test_fingers_are_looked_at_five_times_a_second() -> None:
    finger = stand_in()
    watch = LimitWatch(needs_as_they_are)
    looks = []
    for ms in range(1000):
        before = len(finger.asked)
        watch.look({"index": finger}, 10.0, 7 * S + ms * S // 1000)
        looks += [ms] * (len(finger.asked) > before)
    assert looks == [0, 200, 400, 600, 800]


@pytest.mark.parametrize(("torque", "counted"), [(math.nan, 0.0), (0.01, 0.01), (-0.01, -0.01)])
def test_of_a_torque_that_is_not_known_the_need_grows_as_without_one(torque: float, counted: float) -> None:
    finger = stand_in()
    finger.memory["DEMAND_TORQUE"] = torque
    watch = LimitWatch(needs_as_they_are)
    watch.look({"index": finger}, 10.0, 0)
    assert finger.asked == [(2.0, counted), (3.0, pytest.approx(1.5 * counted))]
    assert watch.state("index") == "near"


@pytest.mark.parametrize(("least", "said"), [(6.6, ""), (6.7, "near")])
def test_where_the_load_needs_nothing_now_the_need_grows_as_the_load_does(least: float, said: str) -> None:
    finger = stand_in(least, estimator=SimpleNamespace(least_force=lambda *_: 0.0))
    watch = LimitWatch(needs_as_they_are)
    watch.look({"index": finger}, 10.0, 0)
    assert watch.state("index") == said


@pytest.mark.parametrize("which", ["command", "standing_command"])
@pytest.mark.parametrize(("reason", "said"), [(Reason.MAX_LIMIT, "reached"), (Reason.HOLD, "")])
def test_either_command_at_the_limit_says_that_it_is_reached(which: str, reason: Reason, said: str) -> None:
    finger = stand_in(1.0, **{which: lambda: SimpleNamespace(reason=reason)})
    watch = LimitWatch(needs_as_they_are)
    watch.look({"index": finger}, 10.0, 0)
    assert watch.state("index") == said


@pytest.mark.parametrize(
    "needs",
    [
        {"thumb": 1.0, "index": math.inf, "middle": 3.0},
        {"thumb": math.inf, "index": math.inf},
        {"thumb": 1.0, "index": math.inf, "middle": math.inf},
    ],
)
def test_where_no_force_suffices_for_another_finger_each_keeps_its_own_need(needs: dict[str, float]) -> None:
    assert against_thumb(needs, "thumb") == needs


@pytest.mark.parametrize(
    ("growth", "more"), [(1.5, "10.5 N"), (1.76, "12.3 N"), (math.inf, "more than any force")]
)
def test_a_warning_says_what_is_needed_now_and_for_half_as_much_load_again(
    caplog: pytest.LogCaptureFixture, growth: float, more: str
) -> None:
    watch = LimitWatch(needs_as_they_are)
    watch.look({"index": stand_in(7.0, growth)}, 10.0, 0)
    watch.log_changes(logging.getLogger("vegrip.test"), 10.0)
    watch.log_changes(logging.getLogger("vegrip.test"), 10.0)
    assert warnings(caplog) == [
        "index: limits.max_force (10 N) may stop the grip: 7 N are needed now, and "
        f"{more} for half as much load again"
    ]
