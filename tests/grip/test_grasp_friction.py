"""What the fingers of a controller learn of friction together, with the real estimators."""

import math
from dataclasses import replace

import numpy as np
import pytest

import vegrip
from vegrip.clock import NS
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.grip import grasp_friction
from vegrip.grip.controller import GripController
from vegrip.grip.drive_lag import set_drives
from vegrip.grip.friction_belief import average_belief, widen_belief
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.grasp_friction import GraspFriction
from vegrip.grip.grasp_memory import BELIEF_MOST, BELIEF_ROW
from vegrip.grip.known_objects import ObjectFriction
from vegrip.grip.node import GraspForce
from vegrip.grip.settings import ControlSettings
from vegrip.grip.slip_channels import SCATTER
from vegrip.messages import KNOWN, PROBED, Condition, FingertipState

NAMES = ("thumb", "index")
LEARNING = FrictionSettings(learning=True)
PERIOD = NS // 500


def controller(friction: FrictionSettings = LEARNING) -> GripController:
    settings = replace(ControlSettings(), friction=friction)
    return GripController(NAMES, vegrip.paper_model(tip_radius=9e-3), settings=settings)


class Bench:
    """Fingers pressed to 2 N, with a tangential load and what is said of slip, whose speed is noisy."""

    def __init__(self, hand: GripController) -> None:
        self.hand, self.tick = hand, 0
        self.force = dict.fromkeys(NAMES, 2.0)

    def run(
        self,
        seconds: float,
        load: float,
        slip: dict[str, float] | None = None,
        speed: float = 0.0,
        all_speeds: float = 0.0,
    ) -> None:
        for _ in range(round(500 * seconds)):
            self.tick += 1
            now = self.tick * PERIOD
            noise = 0.004 * (-1) ** self.tick
            depth = 1e-3 * min(1.0, self.tick / 100)
            force = 2.0 * (depth / 1e-3) ** 1.5
            states = [
                FingertipState(
                    now, name, self.tick, force + noise, load * force / 2.0, 0.0, 0.0, depth, 22.0,
                    (slip or {}).get(name, 0.0),
                    2e-5 * (1 + (-1) ** self.tick)
                    + (speed if (slip or {}).get(name, 0.0) >= 0.5 else all_speeds),
                )
                for name in NAMES
            ]  # fmt: skip
            self.hand.step(states, now)

    def bound(self, name: str) -> float:
        mean, std = self.hand.friction.belief(name)
        return mean - 0.7 * std


@pytest.fixture(scope="module")
def held() -> Bench:
    bench = Bench(controller())
    bench.run(1.0, 0.6)
    return bench


def test_before_anything_is_felt_friction_is_what_is_published_of_soft_tips_at_this_load(held: Bench) -> None:
    for name in NAMES:
        mean, std = held.hand.friction.belief(name)
        assert math.exp(mean) == pytest.approx(0.92 * 0.5 * (2.0 / 5.0) ** -0.15, rel=0.02)
        assert std == pytest.approx(math.hypot(0.35, 0.1, 0.12 * math.log(5.0 / 2.0)), abs=0.01)


@pytest.mark.parametrize(("std", "counts"), [(0.02, True), (2.0, False)])
def test_what_is_known_of_an_object_counts_where_it_is_more_than_is_known_of_the_tips(
    std: float, counts: bool
) -> None:
    hand = controller()
    estimators = {name: finger.estimator for name, finger in hand.fingers.items()}
    settings = replace(ControlSettings(), friction=LEARNING)
    usual = GraspFriction(estimators, settings)
    found = GraspFriction(estimators, settings, ObjectFriction(-1.7, std))
    assert (found.memory.belief.version == 1.0) == counts
    for name in NAMES:
        mean, spread = found.belief(name)
        if counts:
            difference = usual.belief(name)[0] - mean
            law = estimators[name].friction_law
            assert difference == pytest.approx(law[0] + 1.7)
            assert spread < usual.belief(name)[1]
        else:
            assert (mean, spread) == usual.belief(name)


def test_a_slide_of_one_finger_lowers_the_bounds_of_all_and_reaches_their_estimators() -> None:
    bench = Bench(controller())
    bench.run(1.0, 0.6)
    before = {name: bench.bound(name) for name in NAMES}
    bench.run(0.04, 0.6, {"index": 1.0}, speed=2e-3)
    bench.run(0.01, 0.6)
    assert all(bench.bound(name) < before[name] for name in NAMES)
    for name in NAMES:
        believed = math.exp(bench.hand.friction.belief(name)[0])
        own = bench.hand.fingers[name].estimator.contact_estimate().friction_coefficient.value
        assert own == pytest.approx(believed, rel=0.02)
        stated = bench.hand.contact(name).friction_coefficient
        assert stated.value < believed + stated.std
        assert own < 0.5


@pytest.mark.parametrize("finger", NAMES)
@pytest.mark.parametrize(("channel", "first"), [("slip", 0), ("slip_speed", BELIEF_MOST)])
def test_a_channel_that_is_surely_not_sound_is_named_at_its_finger_alone(
    finger: str, channel: str, first: int
) -> None:
    learned = controller().friction
    assert {learned.doubted_channel(name) for name in NAMES} == {""}
    learned.memory.slip.sound[first + NAMES.index(finger)] = 0.0
    expected = {name: channel if name == finger else "" for name in NAMES}
    assert {name: learned.doubted_channel(name) for name in NAMES} == expected


def test_fingers_that_do_not_share_learn_alone() -> None:
    bench = Bench(controller(FrictionSettings()))
    bench.run(1.0, 0.6)
    bench.run(0.04, 0.6, {"index": 1.0}, speed=2e-3)
    assert bench.hand.contact("thumb").friction_coefficient.value == pytest.approx(0.92 * 0.573, rel=0.05)
    assert bench.hand.contact("index").friction_coefficient.value < 0.4


def test_slip_that_is_felt_for_one_sample_changes_nothing(held: Bench) -> None:
    before = [held.hand.friction.belief(name) for name in NAMES]
    held.run(0.002, 0.6, {"index": 1.0}, speed=2e-3)
    held.run(0.1, 0.6)
    after = [held.hand.friction.belief(name) for name in NAMES]
    assert [m for m, _ in after] == pytest.approx([m for m, _ in before], abs=1e-3)
    assert [s for _, s in after] == pytest.approx([s for _, s in before], abs=1e-3)


@pytest.mark.parametrize("seconds", [0.06, 0.2])
def test_one_slide_counts_once(seconds: float) -> None:
    bench = Bench(controller())
    bench.run(1.0, 0.6)
    _, before = bench.hand.friction.belief("index")
    bench.run(seconds, 0.6, {"index": 1.0}, speed=2e-3)
    _, std = bench.hand.friction.belief("index")
    assert std >= before * SCATTER / math.hypot(before, SCATTER)


@pytest.mark.parametrize("friction", [LEARNING, FrictionSettings()], ids=["shared", "alone"])
@pytest.mark.parametrize("slip", [0.5, 0.99])
def test_a_slip_between_0_and_1_raises_no_grip_and_teaches_nothing(
    friction: FrictionSettings, slip: float
) -> None:
    told = []
    for said in (math.nan, slip):
        bench = Bench(controller(friction))
        bench.run(1.0, 0.6)
        bench.run(0.3, 0.6, {"index": said})
        force = bench.hand.fingers["index"].held
        told.append((bench.hand.contact("index").friction_coefficient.value, force))
    assert told[1] == told[0]


def test_a_bogus_slip_at_light_touch_changes_nothing() -> None:
    bench = Bench(controller())
    bench.run(1.0, 0.012)  # a load like the noise of its measurement
    before = [bench.hand.friction.belief(name) for name in NAMES]
    bench.run(0.1, 0.012, {"index": 1.0}, speed=2e-3)
    bench.run(0.1, 0.012)
    for name, (mean, _) in zip(NAMES, before, strict=True):
        assert bench.hand.friction.belief(name)[0] == pytest.approx(mean, abs=2e-3)
        own = bench.hand.contact(name).friction_coefficient.value
        assert own == pytest.approx(math.exp(mean), rel=0.02)


@pytest.mark.parametrize(
    ("friction", "slip", "sentence"),
    [
        (LEARNING, 0.0, "the slip channel of thumb has not reported a slide yet, and may be dead"),
        (LEARNING, math.nan, "thumb does not feel slip"),
        (replace(LEARNING, slip_threshold=5e-4), 0.0, "slip is felt from 0.0005 m/s on"),
        (replace(LEARNING, slip_delay=0.04), 0.0, "slip is felt 0.04 s late"),
        (replace(LEARNING, learning=False), 0.0, "friction is not learned"),
    ],
    ids=["not proven", "absent", "coarse", "late", "off"],
)
def test_probing_says_why_it_is_off_and_is_careful_then(
    friction: FrictionSettings, slip: float, sentence: str
) -> None:
    bench = Bench(controller(friction))
    seconds = 1.0
    bench.run(seconds, 0.6, dict.fromkeys(NAMES, slip), all_speeds=slip)
    why = bench.hand.friction.why_not_probing
    assert why.startswith(sentence)
    assert bool(why) == bool(sentence)
    careful = Bench(controller(FrictionSettings()))
    careful.run(seconds, 0.6, dict.fromkeys(NAMES, slip), all_speeds=slip)
    if not sentence.startswith("the slip channel"):
        needs = [b.hand.fingers["index"].memory["GRIP_REQUIRED"] for b in (bench, careful)]
        assert needs[1] <= needs[0] < 1.05 * needs[1]  # friction may have changed, and nobody would notice


def test_a_slip_speed_of_a_slide_raises_the_grip_without_a_flag() -> None:
    forces = []
    for speed in (0.0, 5e-3):
        bench = Bench(controller())
        bench.run(2.0, 0.6)
        bench.run(0.02, 0.6, all_speeds=speed)
        forces.append(bench.hand.fingers["index"].memory["GRIP_REQUIRED"])
    assert forces[1] > 1.1 * forces[0]


def test_a_drive_that_is_too_late_for_the_load_to_be_a_witness_is_told_with_its_lag() -> None:
    bench = Bench(controller())
    bench.run(0.1, 0.6)
    hand = bench.hand.friction
    set_drives(hand.memory, 0.03, 4.0)
    assert hand.why_not_probing.startswith("a drive lags by 0.030 s")
    hand.memory.slip.sound[0], hand.memory.slip.silent[0] = 0.99, 0.005
    assert "lags" not in hand.why_not_probing


def test_a_node_logs_once_why_friction_is_not_probed(caplog: pytest.LogCaptureFixture) -> None:
    settings = replace(ControlSettings(), friction=LEARNING)
    model = vegrip.paper_model(tip_radius=9e-3)
    node = GraspForce("grip", NAMES, lambda _: ContactEstimator(model, SensorNoise()), settings)
    node.configure()
    node.activate()
    with caplog.at_level("INFO", logger="vegrip.grip"):
        for tick in range(1, 600):
            state = FingertipState(
                tick * PERIOD, "thumb", tick, 2.0 + 0.004 * (-1) ** tick, 0.6, 0.0, 0.0, 1e-3
            )
            list(node.on_message(state, state.stamp))
    told = [record.getMessage() for record in caplog.records]
    assert told == ["friction is not probed: thumb does not feel slip"]


def test_health_says_that_friction_is_probed_and_a_finger_that_does_not_learn_says_nothing() -> None:
    seen = []
    for friction in (LEARNING, FrictionSettings()):
        bench = Bench(controller(friction))
        bench.run(0.1, 0.6)
        told = {bench.hand.health("index").friction}
        for _ in range(40):
            bench.run(0.05, 0.6)
            told.add(bench.hand.health("index").friction)
        seen.append(told)
    assert seen[0] >= {"", PROBED}
    assert seen[1] == {""}


@pytest.mark.parametrize(
    ("std", "noticed", "shift", "said"),
    [
        (0.199, 0.95, 0.0, KNOWN),
        (0.201, 0.95, 0.0, ""),
        (0.199, 0.949, 0.0, ""),
        (0.201, 0.949, 0.0, ""),
        (0.199, 0.95, 0.2, PROBED),
        (0.5, 0.5, 0.2, PROBED),
    ],
)
def test_friction_is_known_where_it_is_narrow_and_a_slide_would_be_noticed(
    monkeypatch: pytest.MonkeyPatch, std: float, noticed: float, shift: float, said: str
) -> None:
    friction = controller().friction
    monkeypatch.setattr(grasp_friction, "believed_variance", lambda *_: std**2)
    monkeypatch.setattr(grasp_friction, "chance_noticed", lambda _: noticed)
    friction.memory.release.shift[1] = shift
    assert friction.friction_counted_on("index") == said
    assert friction.friction_counted_on("thumb") == (said if shift == 0.0 else KNOWN * (noticed > 0.9))


LOAD = ("normal_force", "tangential_force_x", "tangential_force_y")
COARSE = replace(LEARNING, slip_threshold=5e-4)


@pytest.mark.parametrize(
    ("friction", "channels", "sentence"),
    [
        (LEARNING, ("normal_force",), ""),
        (LEARNING, LOAD, "thumb grips by the friction of its model; to grip less: it must feel slip"),
        (FrictionSettings(), (*LOAD, "slip"), "its own slides teach; to grip less: vegrip calibrate"),
        (COARSE, (*LOAD, "slip"), "slides of all fingers teach; to grip less: slip is felt from"),
    ],
)  # fmt: skip
def test_a_node_says_of_a_finger_what_it_grips_by_and_what_it_takes_to_grip_less(
    friction: FrictionSettings, channels: tuple[str, ...], sentence: str
) -> None:
    settings = replace(ControlSettings(), friction=friction)
    model = vegrip.paper_model(tip_radius=9e-3)
    node = GraspForce("grip", NAMES, lambda _: ContactEstimator(model, SensorNoise()), settings)
    node.configure()
    node.activate()
    said = node.describe_finger("thumb", channels)
    assert sentence in said
    assert bool(said) is bool(sentence)


def test_a_state_that_is_refused_says_nothing_of_slip_and_takes_no_time() -> None:
    """For a second every state has a normal force out of range, and reports slip."""
    bench = Bench(controller())
    bench.run(1.0, 0.6)
    slip = bench.hand.friction.memory.slip
    slip.sound[0], slip.silent[0] = 0.993, 0.004
    for _ in range(500):
        bench.tick += 1
        now = bench.tick * PERIOD
        states = [FingertipState(now, name, bench.tick, 1e9, 0.6, slip=1.0) for name in NAMES]
        bench.hand.step(states, now)
    assert bench.hand.fingers["thumb"].condition == Condition.OUT_OF_RANGE
    assert slip.sound[0] == 0.993
    assert slip.slides[0] == 0.0


@pytest.mark.parametrize("fails", ["silent", "refused"])
def test_a_finger_that_is_not_heard_returns_to_what_it_held_before_force_was_lowered(fails: str) -> None:
    """It would not tell of a slide. With 10 N/s, from the first instant of the fault on."""
    bench = Bench(controller())
    bench.run(1.0, 0.6)
    thumb = bench.hand.fingers["thumb"]
    bench.hand.friction.memory.release.shift[0] = 0.4
    before = thumb.memory["GRIP_LOWERED_FROM"] = thumb.held + 0.5
    for _ in range(100):
        bench.tick += 1
        now, force = bench.tick * PERIOD, 2.0 + 0.004 * (-1) ** bench.tick
        states = [FingertipState(now, "index", bench.tick, force, 0.6, 0.0, 0.0, 1e-3, 22.0, 0.0, 0.0)]
        if fails == "refused":
            states.append(FingertipState(now, "thumb", bench.tick, 1e9, 0.6, slip=0.0))
        bench.hand.step(states, now)
    assert thumb.condition > Condition.DEGRADED
    assert thumb.held == pytest.approx(before)


@pytest.mark.parametrize("felt", ["flag", "speed"])
def test_a_load_that_held_teaches_whichever_channel_tells_that_it_did(felt: str) -> None:
    """Without either nobody knows whether it held, and nothing is learned."""
    settings = replace(LEARNING, slip_threshold=1e-4)
    bench, blind = Bench(controller(settings)), Bench(controller(settings))
    flag, speed = (0.0, math.nan) if felt == "flag" else (math.nan, 0.0)
    before = bench.hand.friction.belief("index")[0]
    for one, says in ((bench, (flag, speed)), (blind, (math.nan, math.nan))):
        for _ in range(1500):
            one.tick += 1
            now, noise = one.tick * PERIOD, 0.004 * (-1) ** one.tick
            part = min(1.0, one.tick / 200)
            states = [
                FingertipState(
                    now, name, one.tick, 2.0 * part**1.5 + noise, 0.9 * part**1.5, 0.0, 0.0, 1e-3 * part,
                    22.0, *says,
                )
                for name in NAMES
            ]  # fmt: skip
            one.hand.step(states, now)
    assert bench.hand.friction.memory.belief.site[1] > 0.0
    assert bench.hand.friction.belief("index")[0] > before
    assert blind.hand.friction.memory.belief.site[1] == 0.0


def test_what_is_kept_of_an_object_is_what_was_believed_at_any_time_of_any_finger() -> None:
    """A mixture: 3 s of (ln 0.4, ln 0.5) with variances (0.02, 0.04), and 1 s in which all is 0.3 lower."""
    friction = Bench(controller()).hand.friction
    belief = friction.memory.belief
    assert friction.learned_object is None
    logs = np.array([math.log(0.4), math.log(0.5)])
    belief.p[0], belief.p[BELIEF_ROW + 1] = 0.02, 0.04
    for forces, seconds, lower in (
        (3.0, 3.0, 0.0),
        (0.0, 9.0, 2.0),
        (3.0, 1.0, 0.3),
    ):  # in between in the air
        friction.memory.witness.forces[0] = forces
        belief.mean[0], belief.mean[1] = logs - lower
        average_belief(friction.memory, seconds)
    times = np.repeat([0.0, 0.0, 0.0, 0.3], 2)
    every = np.tile(logs, 4) - times
    found = friction.learned_object
    std = math.sqrt(np.var(every) + 0.03)
    assert found == ObjectFriction(pytest.approx(np.mean(every)), pytest.approx(std))


def test_what_may_be_a_lie_is_not_kept_of_an_object() -> None:
    friction = Bench(controller()).hand.friction
    g = friction.memory
    g.witness.forces[0], g.belief.doubted[0] = 3.0, 1.0
    g.belief.since = 1.0
    widen_belief(g)
    assert g.belief.lasted == 0.0
    g.belief.since, g.belief.doubted[0] = 1.0, 0.0
    widen_belief(g)
    assert g.belief.lasted == 1.0


def test_where_nothing_is_learned_nothing_is_kept() -> None:
    friction = Bench(controller()).hand.friction
    friction.memory.witness.forces[0] = 3.0
    average_belief(friction.memory, 5.0)
    assert friction.learned_object is None
