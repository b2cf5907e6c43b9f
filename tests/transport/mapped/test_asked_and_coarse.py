"""Hands that answer when asked, and sensors in coarse steps, on a bus in simulated time."""

import math
from collections import Counter
from statistics import NormalDist

import pytest

from tests.grip.stages import Watchdog
from tests.transport.maps.hands import load, seeded, written
from validation.faults.simulated_can import SimulatedCan
from vegrip.clock import NS, SimulatedClock
from vegrip.config import build
from vegrip.estimator.settings import SensorNoise
from vegrip.grip.safety import WatchdogSettings
from vegrip.messages import Condition, ForceCommand, Reason
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.price import USUAL_NOISE, price, settings

MS = 1_000_000
ASK, STATE, SET = 0x30, 0x31, 0x32

DBC = """VERSION ""
BU_: Hand PC
BO_ 49 St: 8 Hand
 SG_ Fz : 0|16@1- ({step},0) [0|0] "N" PC
 SG_ Fx : 16|16@1- ({step},0) [0|0] "N" PC
 SG_ Fy : 32|16@1- ({step},0) [0|0] "N" PC
 SG_ Roll : 48|8@1+ (1,0) [0|255] "" PC
BO_ 50 Set: 2 PC
 SG_ Grip : 0|16@1+ (0.01,0) [0|50] "N" Hand
"""

MAP = """
database = "own.dbc"
rate = 200.0
[messages.St]
counter = "Roll"
[fingers.jaw.normal_force]
signal = "St.Fz"
noise = {noise}
[fingers.jaw.tangential_force_x]
signal = "St.Fx"
zero_is_measured = true
noise = {noise}
[fingers.jaw.tangential_force_y]
signal = "St.Fy"
zero_is_measured = true
noise = {noise}
[fingers.jaw.command]
signal = "Set.Grip"
[device]
poll = [{{ identifier = 0x30, data = "" }}]
"""


class Bus:
    """The hand and this computer on one simulated bus."""

    def __init__(self, folder, step, noise):
        path = written(folder, DBC.format(step=step), MAP.format(noise=noise), "own.dbc")
        self.plan = open_plan(path)
        self.codec = MappedCodec(self.plan)
        self.clock = SimulatedClock()
        bus = SimulatedCan(self.clock)
        self.host = bus.endpoint(self.codec)
        self.hand = bus.endpoint(self.codec)
        self.hand.intercept = self.hear
        self.heard = Counter()
        self.noise, self.count, self.answers = lambda: 0.0, 0, True
        self.database = load(DBC.format(step=step))

    def hear(self, frame):
        self.heard[frame.arbitration_id] += 1
        if frame.arbitration_id == ASK and self.answers:
            self.say()
        return True

    def say(self):
        self.count += 1
        forces = {"Fz": 1.0 + self.noise(), "Fx": self.noise(), "Fy": self.noise()}
        values = {**forces, "Roll": self.count % 256}
        data = self.database.encode_message("St", values, strict=False)
        self.hand.send_frame(Frame(STATE, bytes(data)))

    def turn(self, now):
        """Bring both ends to ``now``; return the states that arrived."""
        self.clock.sleep_until(now)
        for frame in self.codec.due(now):
            self.host.send_frame(frame)
        states = self.host.receive(0.0)
        self.hand.receive(0.0)
        return states


def command(stamp):
    return ForceCommand(stamp, "jaw", 0, 2.0, 0.0, Reason.HOLD, stamp + 100 * MS)


def test_a_hand_that_is_asked_is_asked_on_while_commands_flow(tmp_path):
    bus = Bus(tmp_path, 0.01, 0.02)
    states = Counter()
    for now in range(MS, 2 * NS, MS):
        if now > NS and now % (5 * MS) == 0:
            for frame in bus.codec.encode(command(now)):
                bus.host.send_frame(frame)
        states[now > NS] += len(bus.turn(now))
    assert bus.heard[SET] >= 190
    assert states[False] >= 45
    assert states[True] == pytest.approx(states[False], abs=3)


def watched(bus, seconds, noise):
    """Let the hand speak at 200 Hz; return the watchdog and when it first called the finger frozen [s]."""
    bus.noise, bus.answers = noise, False
    given = build(WatchdogSettings, settings(bus.plan).get("watchdog", {}), "watchdog")
    watchdog, frozen = Watchdog(given), math.inf
    for n in range(1, round(seconds * 200)):
        bus.say()
        for state in bus.turn(n * 5 * MS):
            watchdog.accept(state, bus.clock.now())
        if watchdog.condition == Condition.FROZEN:
            frozen = min(frozen, n / 200)
    return watchdog, frozen


def test_a_coarse_sensor_at_rest_behind_a_counter_that_runs_is_not_frozen(tmp_path):
    bus = Bus(tmp_path, 0.1, 0.0289)  # as a log at rest gives it: the noise of the steps
    watchdog, frozen = watched(bus, 10.0, lambda: 0.0)
    assert frozen == math.inf
    assert watchdog.doubtful  # and still nothing is lowered on its word
    assert any("the steps of normal_force hide its noise" in sentence for sentence in price(bus.plan))


def test_a_sensor_whose_noise_moves_it_is_frozen_when_it_stands_still(tmp_path):
    bus = Bus(tmp_path, 0.1, 0.06)
    noise = seeded(1)
    live = math.sqrt(0.06**2 - 0.1**2 / 12)
    _, frozen = watched(bus, 20.0, lambda: noise.gauss(0.0, live) if bus.clock.now() < 15 * NS else 0.0)
    assert 15.0 < frozen < 16.0


def test_no_live_sensor_in_the_middle_of_a_step_is_called_frozen(tmp_path):
    bus, random = Bus(tmp_path, 0.1, 0.036), seeded(2)
    live = math.sqrt(0.036**2 - 0.1**2 / 12)
    _, frozen = watched(bus, 30.0, lambda: random.gauss(0.0, live))
    assert frozen == math.inf


@pytest.mark.parametrize("rate", [500.0, 200.0, 20.0, None])
@pytest.mark.parametrize("noise", [0.0289, 0.0291, 0.031, 0.036, 0.045, 0.06, 0.1, 5.0])
def test_a_sensor_stands_still_once_chance_repeats_it_less_than_once_in_ten_million(tmp_path, noise, rate):
    """A value in the middle of a step stays there by the normal law; of three channels, independently.

    A rate that is not stated counts as 60 Hz, and no wait is longer than half an hour.
    """
    stated = "" if rate is None else f"rate = {rate}\n"
    text = MAP.format(noise=noise).replace("rate = 200.0\n", stated)
    found = settings(open_plan(written(tmp_path, DBC.format(step=0.1), text, "own.dbc"))).get("watchdog", {})
    variance = noise**2 - 0.1**2 / 12
    stays = 1.0 - 2.0 * NormalDist(0.0, math.sqrt(variance)).cdf(-0.05) if variance > 0.0 else 1.0
    for name, channels, usual in (("force_frozen_after", 1, 2.0), ("frozen_after", 3, 0.25)):
        run = math.log(1e-7) / (channels * math.log(stays)) if stays < 1.0 else math.inf
        assert found.get(name, usual) == pytest.approx(
            max(min(run / (rate or 60.0), 1800.0), usual), abs=6e-4
        )


@pytest.mark.parametrize(("step", "travel"), [(0.1, None), (0.5, 1.5e-3), (0.4567, 1.37e-3)])
def test_steps_that_a_press_may_stay_within_ask_for_a_longer_press(tmp_path, step, travel):
    """Three steps on a soft tip of 1 N/mm, to a micrometre."""
    found = settings(Bus(tmp_path, step, step / math.sqrt(12.0)).plan)["watchdog"]
    assert found.get("stuck_travel") == travel


def test_fine_steps_leave_the_watchdog_as_it_is(tmp_path):
    assert "watchdog" not in settings(Bus(tmp_path, 0.001, 0.01).plan)


def test_the_noise_that_is_believed_without_a_statement_is_that_of_the_estimator():
    usual = SensorNoise()
    assert {name: getattr(usual, name) for name in USUAL_NOISE} == USUAL_NOISE
