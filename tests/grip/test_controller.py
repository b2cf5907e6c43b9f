"""The grip controller without a bus gives what the node gives, and needs no node."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pytest

import vegrip
from tests.grip.conftest import ConeEstimator
from vegrip.config import check
from vegrip.errors import ConfigError, KindError, UsageError
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.grip.controller import GripController
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.known_objects import ObjectFriction
from vegrip.grip.node import GraspForce
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.safety import FailSafeSettings, LimitSettings, WatchdogSettings
from vegrip.grip.settings import ControlSettings
from vegrip.grip.step_time import StepTime
from vegrip.messages import Condition, ContactEstimate, FingertipState, ForceCommand, Reason
from vegrip.model import ContactModel, paper_model

MakeState = Callable[..., FingertipState]
PERIOD = 2_000_000  # [ns]
FINGERS = ("thumb", "index")
RADIUS = 8e-3


@pytest.fixture(scope="module")
def model() -> ContactModel:
    return paper_model(RADIUS)


@pytest.fixture(scope="module")
def hand(model: ContactModel) -> GripController:
    return GripController(FINGERS, model=model)


@pytest.fixture
def controller(hand: GripController) -> GripController:
    hand.reset(ControlSettings())
    return hand


def held(model: ContactModel, seconds: float) -> Iterator[list[FingertipState]]:
    """The states of a pinch of 3 N that is loaded a little more with time, both fingers at once."""
    stiffness = model.simulate([0.0, 1.0], [0.0, 1e-3]).normal_force[-1] / 1e-3**1.5
    depth = (3.0 / stiffness) ** (1.0 / 1.5)
    for i in range(round(seconds * 1e9 / PERIOD)):
        wobble = 1e-2 * math.sin(1.7 * i)
        values = {
            "normal_force": 3.0 + wobble,
            "tangential_force_x": 0.5 + 0.2 * i * PERIOD / 1e9 + 0.3 * wobble,
            "tangential_force_y": 0.3 * wobble,
            "torque_z": 1e-2 * wobble,
            "displacement": depth + 5e-4 * wobble,
            "slip": 0.0,
        }
        yield [FingertipState(stamp=i * PERIOD, finger=name, seq=i, **values) for name in FINGERS]


def test_its_commands_are_those_of_the_node(controller: GripController, model: ContactModel) -> None:
    estimators = {name: controller.fingers[name].estimator for name in FINGERS}
    node = GraspForce(
        "grasp", FINGERS, lambda name: type(estimators[name])(model, SensorNoise()), ControlSettings()
    )
    node.configure()
    node.activate()
    for i, states in enumerate(held(model, 1.0)):
        for state in states[: 1 if 200 < i < 350 else 2]:  # one finger is silent for 0.3 s
            alone = controller.step([state], i * PERIOD)
            answers = [*node.on_message(state, i * PERIOD), *node.on_tick(i * PERIOD)]
            assert alone == [m for m in answers if isinstance(m, ForceCommand)]


def test_it_tells_contact_margin_and_health_of_each_finger(
    controller: GripController, model: ContactModel
) -> None:
    for i, states in enumerate(held(model, 0.6)):
        commands = controller.step(states, i * PERIOD)
        assert [c.finger for c in commands] == list(FINGERS)
    for name in FINGERS:
        contact = controller.contact(name)
        assert contact.finger == name
        assert contact.normal_force.value == pytest.approx(3.0, abs=0.05)
        assert contact.normal_force.valid
        assert 0.0 < controller.margin(name).lower_bound < controller.margin(name).margin.value < 1.0
        assert controller.health(name).condition == Condition.OK


def test_silence_is_ridden_out_and_the_contact_is_no_longer_valid(
    controller: GripController, model: ContactModel
) -> None:
    for i, states in enumerate(held(model, 0.6)):
        controller.step(states, i * PERIOD)
    before = {c.finger: c.normal_force for c in controller.step([], (i + 20) * PERIOD)}
    commands: list[ForceCommand] = []
    for j in range(i + 20, i + 900):
        commands += controller.step([], j * PERIOD)
    last = {c.finger: c for c in commands}
    assert last.keys() == set(FINGERS)
    for name, command in last.items():
        assert command.normal_force >= max(before.get(name, 0.0), ControlSettings().fail_safe.force)
        assert command.reason in (Reason.FAIL_SAFE, Reason.INPUT_HOLD)
        assert controller.health(name).condition == Condition.STALE
        assert not controller.contact(name).normal_force.valid
        assert math.isnan(controller.margin(name).lower_bound)


def test_no_command_is_left_to_expire_while_it_is_called(
    controller: GripController, model: ContactModel
) -> None:
    states = list(held(model, 0.2))
    expires = dict.fromkeys(FINGERS, math.inf)
    for i in range(1000):
        for command in controller.step(states[i] if i < len(states) else [], i * PERIOD):
            assert i * PERIOD < expires[command.finger]
            expires[command.finger] = command.expires
    assert min(expires.values()) > 999 * PERIOD


def test_a_state_of_another_hand_is_counted_and_commands_nothing(controller: GripController) -> None:
    before = controller.rejected["unknown finger"]
    assert controller.step([FingertipState(0, "toe", 0, 1.0)], 0) == []
    assert controller.rejected["unknown finger"] == before + 1
    with pytest.raises(UsageError, match="no finger 'indx'; there are thumb, index; did you mean index"):
        controller.contact("indx")


def test_before_the_first_state_nothing_is_known_and_nothing_commanded(controller: GripController) -> None:
    assert controller.step([], 1_000) == []
    assert controller.contact("thumb") == dataclasses.replace(ContactEstimate(0, "thumb", 0))
    assert not controller.margin("thumb").margin.valid
    assert not controller.health("thumb").consistent


def test_new_settings_count_at_once(controller: GripController, model: ContactModel) -> None:
    states = list(held(model, 0.4))
    for i in range(100):
        controller.step(states[i], i * PERIOD)
    limits = dataclasses.replace(controller.settings.limits, min_force=9.0)
    controller.settings = dataclasses.replace(controller.settings, limits=limits)
    for i in range(100, 200):
        commands = controller.step(states[i], i * PERIOD)
    assert all(command.normal_force >= 9.0 for command in commands)


def test_a_hand_without_a_model_or_with_too_few_is_refused(model: ContactModel) -> None:
    with pytest.raises(UsageError, match="needs the model of its fingertips"):
        vegrip.GripController(FINGERS)
    with pytest.raises(UsageError, match="there is no model of index; there are models of thumb"):
        vegrip.GripController(FINGERS, model={"thumb": model})


@pytest.mark.parametrize(
    ("fingers", "sentence"),
    [
        (("a", "b", "a"), "^more than one finger is called a; give each a name of its own$"),
        ("thumb", r"^fingers is 'thumb'; give the names of the fingers, as in \('thumb', 'index'\)$"),
        ((1, 2), r"^fingers is \(1, 2\); give the names"),
        ((None,), "give the names of the fingers"),
    ],
)
def test_fingers_that_names_do_not_tell_apart_are_refused(
    fingers: Any, sentence: str, model: ContactModel
) -> None:
    with pytest.raises(UsageError, match=sentence):
        GripController(fingers, model)


def test_a_second_controller_commands_as_the_first_one(model: ContactModel) -> None:
    first, second = (GripController(FINGERS, model=model) for _ in range(2))
    for states in held(model, 0.2):
        now = states[0].stamp
        assert first.step(states, now) == second.step(states, now)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"limits": LimitSettings(lifetime=-1)}, "s.limits: 'lifetime' is -1; it must lie in 0.001 .. 10 s$"),
        ({"limits": LimitSettings(raise_rate=-1.0)}, "'raise_rate' is -1"),
        ({"limits": LimitSettings(lower_rate=math.nan)}, "'lower_rate' is nan"),
        ({"limits": {"max_force": 8.0}}, "'limits' is .*; it must be a LimitSettings"),
        ({"grip": GripSettings(wanted_margin=math.nan)}, "'wanted_margin' is nan; it must lie in 0 .. 0.9"),
        ({"grip": GripSettings(probability=95)}, "settings.grip: 'probability' is 95; it must lie in"),
        ({"grip": GripSettings(known_probability=1.0)}, "'known_probability' is 1"),
        ({"grip": GripSettings(release_time=0.0)}, "'release_time' is 0"),
        ({"friction": FrictionSettings(load_exponent=5.0)}, "'load_exponent' is 5"),
        ({"friction": FrictionSettings(coefficient=-0.5)}, "'coefficient' is -0.5"),
        ({"friction": FrictionSettings(coefficient=35)}, "'coefficient' is 35"),
        ({"fail_safe": FailSafeSettings(force=math.nan)}, "settings.fail_safe: 'force' is nan"),
        ({"fail_safe": FailSafeSettings(force="5")}, "'force' is '5'; it must be a float in N"),
        ({"watchdog": WatchdogSettings(time_out=-1.0)}, "settings.watchdog: 'time_out' is -1"),
        ({"thumb": "tumb"}, "'thumb' is 'tumb'; there are thumb, index; did you mean thumb"),
    ],
    ids=str,
)  # fmt: skip
def test_settings_out_of_their_bounds_are_refused_in_one_sentence(
    given: dict[str, Any], sentence: str, controller: GripController, model: ContactModel
) -> None:
    settings = ControlSettings(**given)
    with pytest.raises(ConfigError, match=sentence) as refused:
        GripController(FINGERS, model, settings=settings)
    assert "\n" not in str(refused.value)
    with pytest.raises(ConfigError, match=sentence):
        controller.settings = settings
    assert controller.settings == ControlSettings()


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"noise": SensorNoise(displacement=5.0)}, "noise: 'displacement' is 5; it must lie in 1e-18 .. 1 m"),
        ({"noise": SensorNoise(normal_force=math.nan)}, "noise: 'normal_force' is nan"),
        ({"estimator": EstimatorSettings(confidence=95.0)}, "estimator: 'confidence' is 95"),
        ({"estimator": EstimatorSettings(hold="foo")}, "'hold' is 'foo'; it must be one of position, force"),
        ({"estimator": EstimatorSettings(surface="foo")}, "'surface' is 'foo'; it must be one of exact"),
        ({"estimator": EstimatorSettings(horizon=-1.0)}, "estimator: 'horizon' is -1"),
    ],
    ids=str,
)  # fmt: skip
def test_noise_and_estimator_out_of_their_bounds_are_refused_in_one_sentence(
    given: dict[str, Any], sentence: str, model: ContactModel
) -> None:
    with pytest.raises(ConfigError, match=sentence):
        GripController(FINGERS, model, **given)


def test_what_is_usable_is_not_refused(model: ContactModel) -> None:
    settings = ControlSettings(
        limits=LimitSettings(max_force=np.float32(8.0), raise_rate=np.int64(40)), thumb=""
    )
    assert GripController(FINGERS, model, settings=settings).settings is settings
    assert GripController(("left", "right"), model).settings.thumb == "thumb"


FIXED = {
    "thumb": {"thumb": ""},
    "policy": {"policy": "cone"},
    "contacts": {"contacts": {"thumb": {}, "index": {"normal": [0.0, 0.0, -1.0]}}},
    "friction.coefficient, friction.learning": {
        "friction": FrictionSettings(coefficient=0.25, learning=True)
    },
}


@pytest.mark.parametrize("named", FIXED)
def test_what_is_fixed_is_not_changed_while_the_hand_grips(named: str, controller: GripController) -> None:
    before = controller.settings
    with pytest.raises(UsageError, match=rf"^{named} cannot be changed while the hand grips; .* reset\(\)$"):
        controller.settings = ControlSettings(limits=LimitSettings(max_force=8.0), **FIXED[named])
    assert controller.settings is before


@pytest.mark.parametrize("named", FIXED)
def test_a_hand_that_is_reset_to_settings_is_a_new_one_with_them(named: str, model: ContactModel) -> None:
    settings = ControlSettings(grip=GripSettings(wanted_margin=0.3), **FIXED[named])
    new, reset = GripController(FINGERS, model, settings=settings), GripController(FINGERS, model)
    for states in held(model, 0.1):
        reset.step(states, states[0].stamp)
    reset.reset(settings)
    assert reset.settings is settings
    assert reset.friction.active == settings.friction.learning
    for states in held(model, 0.3):
        now = states[0].stamp
        assert reset.step(states, now) == new.step(states, now)
        assert reset.contact("thumb") == new.contact("thumb")


def test_the_friction_that_is_stated_is_that_of_the_estimate_after_a_reset(
    controller: GripController,
) -> None:
    stated = FrictionSettings(coefficient=0.25, coefficient_std=0.05, load_exponent_std=0.0)
    controller.reset(ControlSettings(friction=stated))
    for name in FINGERS:
        estimator = controller.fingers[name].estimator
        assert isinstance(estimator, ContactEstimator)
        apparent = math.log(0.25 * estimator.settings.friction.tangential_gain)
        assert estimator.friction_law.ln_mu == pytest.approx(apparent)
    controller.reset(ControlSettings())


def test_a_reset_to_settings_that_cannot_be_used_leaves_all_as_it_is(controller: GripController) -> None:
    before, fingers = controller.settings, controller.fingers
    with pytest.raises(ConfigError, match="'thumb' is 'tumb'"):
        controller.reset(ControlSettings(thumb="tumb"))
    assert controller.settings is before
    assert controller.fingers is fingers


STEPS = 400
WRONG = 200
"""The step whose time is wrong."""
Told = Callable[[int, int], Any]
"""What a step is told as its time, by its number and its time."""


def commands_of(
    hand: GripController, model: ContactModel, told: Told, set_by: int = 0
) -> list[list[ForceCommand]]:
    """Return the commands of each step; the clock of the states is ``set_by`` [ns] at the wrong one."""
    hand.reset(ControlSettings())
    hand.rejected.clear()
    commands = []
    for i, states in enumerate(held(model, 0.8)):
        stamp = states[0].stamp + (set_by if i >= WRONG else 0)
        stamped = [dataclasses.replace(state, stamp=stamp) for state in states]
        commands.append(hand.step(stamped, told(i, states[0].stamp)))
    return commands


def check_end(hand: GripController, odd: list[list[ForceCommand]], usual: list[list[ForceCommand]]) -> None:
    """Fail unless a hand with an odd clock grips in the end as one with a right clock."""
    assert all(hand.health(name).condition == Condition.OK for name in FINGERS)
    for found, expected in zip(odd[-1], usual[-1], strict=True):
        assert found.finger == expected.finger
        assert found.expires - found.stamp == expected.expires - expected.stamp
        assert found.normal_force == pytest.approx(expected.normal_force, rel=0.1)


@pytest.mark.parametrize(
    ("wrong", "when"),
    [
        *[(wrong, WRONG) for wrong in (3_600_000_000_000, 600_000_000, -10_000_000, -1_000_000_000)],
        *[(wrong, 0) for wrong in (3_600_000_000_000, -1_000_000_000)],
        *[(wrong, WRONG) for wrong in (None, math.nan, "now")],
    ],
)
def test_one_wrong_time_does_not_hold_the_grip_up(
    wrong: Any, when: int, hand: GripController, model: ContactModel
) -> None:
    def told(i: int, now: int) -> Any:
        return now if i != when else now + wrong if isinstance(wrong, int) else wrong

    usual, odd = (commands_of(hand, model, one) for one in (lambda _, now: now, told))
    assert hand.rejected == {"wrong time": 1}
    assert all(len(commands) == len(FINGERS) for commands in odd[when + 3 :])
    assert [command.stamp for command in odd[-1]] == [command.stamp for command in usual[-1]]
    check_end(hand, odd, usual)


@pytest.mark.parametrize("set_by", [3_600_000_000_000, -3_600_000_000_000, -1_000_000_000])
def test_a_clock_that_is_set_is_followed(set_by: int, hand: GripController, model: ContactModel) -> None:
    usual = commands_of(hand, model, lambda _, now: now)
    odd = commands_of(hand, model, lambda i, now: now + (set_by if i >= WRONG else 0), set_by)
    assert hand.rejected == {"wrong time": 1}
    check_end(hand, odd, usual)


@pytest.mark.parametrize(
    ("times", "taken"),
    [
        ((5 * 10**18, 5 * 10**18 + 1), (0, 0)),  # whatever the first one is
        ((7, 9, 9, 9 + 10**9), (0, 0, 0, 0)),  # it stands still, or goes on by a second
        ((7, 9, 10 + 10**9, 10 + 10**9), (0, 0, None, 0)),  # it pauses, which two say
        ((7, 8 + 10**9, 9 + 10**9), (0, None, 2 + 10**9)),  # after a first one that was of no other clock
        ((7, 9, 8, 8, 10), (0, 0, None, -1, 0)),  # it was set back
        ((7, 9, 8, 8, 9 + 10**9, 9 + 10**9), (0, 0, None, -1, None, 1 + 10**9)),  # and at once set again
        ((7, 9, 8, 11, 8), (0, 0, None, 0, None)),  # one wrong time each
        ((7, 9, 8, 8, 10, 11 + 10**9, 11 + 10**9), (0, 0, None, -1, 0, None, 0)),
    ],
)
def test_of_odd_times_the_second_is_believed_as_a_pause_or_as_a_clock_that_was_set(
    times: tuple[int, ...], taken: tuple[int | None, ...]
) -> None:
    time = StepTime()
    assert time.now == 0
    assert tuple(map(time.take, times)) == taken
    assert time.now == [one for one, found in zip(times, taken, strict=True) if found is not None][-1]


@pytest.mark.parametrize("kind", [float, np.int64])
def test_a_time_of_another_kind_of_number_is_a_time(
    kind: Any, hand: GripController, model: ContactModel
) -> None:
    as_told = commands_of(hand, model, lambda _, now: kind(now))
    assert as_told == commands_of(hand, model, lambda _, now: now)


def test_friction_is_not_learned_of_more_fingers_than_the_grasp_keeps(model: ContactModel) -> None:
    """More were taken before and learned nothing, without a word."""
    names = [f"f{i}" for i in range(21)]
    with pytest.raises(ConfigError, match="'learning' is for at most 20 fingers, not 21"):
        GripController(names, model, settings=ControlSettings(friction=FrictionSettings(learning=True)))
    assert GripController(names, model).names == tuple(names)


def test_what_is_known_of_the_object_comes_from_a_function(model: ContactModel) -> None:
    known = ObjectFriction(-0.7, 0.2)
    with pytest.raises(KindError, match=r"known_object is ObjectFriction\(.*\); give a function"):
        GripController(FINGERS, model, known_object=known)  # type: ignore[arg-type]


def test_of_the_needs_only_those_of_fingers_that_have_started_are_shared() -> None:
    """A finger that was never heard needs nothing that is known, and must not hide what the others need."""
    hand = GripController(("thumb", "index"), make_estimator=ConeEstimator)
    told: list[dict[str, float]] = []

    def share(needs: Mapping[str, float]) -> Mapping[str, float]:
        told.append(dict(needs))
        return needs

    hand._share_of = share
    given = {"thumb": math.nan, "index": 3.0}
    for name, need in given.items():
        numbers = hand.fingers[name].numbers
        numbers.shared[numbers.place.number] = need
    assert hand._share(hand.fingers["index"]) == 3.0
    assert hand._share(hand.fingers["thumb"]) == 0.0
    assert told == [{"index": 3.0}] * 2


@pytest.mark.parametrize("horizon", [0.0, 0.5, 3600.0])
def test_a_forecast_may_look_ahead_by_nothing_and_by_an_hour(horizon: float) -> None:
    check(EstimatorSettings(horizon=horizon), "estimator")
    for beyond in (-1e-9, 3600.1):
        with pytest.raises(ConfigError, match="horizon"):
            check(EstimatorSettings(horizon=beyond), "estimator")
