"""Laws of what is said, and set, for what a hand does not tell."""

import math

import pytest
from scipy.stats import norm

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, written
from vegrip.grip.safety import WatchdogSettings
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.mapped.price import price, settings


def said(tmp_path, text):
    return " | ".join(price(open_plan(written(tmp_path, PLAIN_DBC, text))))


def test_each_thing_that_is_missing_is_said_with_its_price(tmp_path):
    told = said(tmp_path, PLAIN_MAP)
    assert "thumb: friction stays as in the model file unless a slip shows" in told
    assert "Pos1: no counter" in told
    assert "Pos1: no checksum" in told
    assert "Tip1: no" not in told
    assert "what it does when they stop is not known" in told
    assert "Grip" not in told


@pytest.mark.parametrize(
    ("gone", "sentence"),
    [
        ('[fingers.thumb.tangential_force_x]\nsignal = "Tip1.Fx"\n', "no slip margin and no grip command"),
        ('[fingers.thumb.torque_z]\nsignal = "Pos1.Tz"\n', "torque_z is not measured and counts as zero"),
        (
            '[fingers.thumb.displacement]\nsignal = "Pos1.Depth"\n',
            "displacement is not measured beside",
        ),
        ("rate = 200.0\n", "the rate of states is not stated"),
        ("set = { Enable = 1 }", "Set1: sent as zero, since the map does not say otherwise: Enable"),
    ],
)
def test_what_is_taken_out_of_the_map_is_told(tmp_path, gone, sentence):
    assert gone in PLAIN_MAP
    assert sentence not in said(tmp_path, PLAIN_MAP)
    assert sentence in said(tmp_path, PLAIN_MAP.replace(gone, ""))


def test_a_stated_load_gives_a_margin_and_says_that_it_is_for_that_load(tmp_path):
    text = PLAIN_MAP.replace(
        'tangential_force_x]\nsignal = "Tip1.Fx"', 'tangential_force_x]\nstated = "1.5 N"'
    )
    told = said(tmp_path, text)
    assert "no slip margin" not in told
    assert "tangential_force_x is stated as 1.5 N, not measured" in told


def test_a_sensor_whose_steps_hide_its_noise_may_stand_still_for_half_an_hour(tmp_path):
    text = PLAIN_MAP.replace('"Tip1.Fz"', '"Tip1.Fz"\nnoise = 0.002')  # a step has 0.01 N
    asked = settings(open_plan(written(tmp_path, PLAIN_DBC, text)))
    assert asked["watchdog"]["force_frozen_after"] == 1800.0


COARSE = {  # signal -> its step and the noise that is measured in front of it, in SI
    "Tip1.Fz": (0.01, 0.004), "Tip1.Fx": (0.01, 0.0035), "Tip1.Fy": (0.01, 0.0032),
    "Pos1.Depth": (1e-6, 3.5e-7), "Pos1.Tz": (1e-4, 3.3e-5),
}  # fmt: skip


@pytest.mark.parametrize(
    ("rate", "counted"), [(200.0, ("Tip1",)), (41.0, ("Tip1",)), (39.0, ("Tip1", "Pos1"))]
)
def test_what_is_held_between_two_of_its_messages_says_nothing_of_a_sensor_that_stands_still(
    tmp_path, rate, counted
):
    """Where more than four states may be of the age of one message; the others all repeat themselves."""
    text = PLAIN_MAP.replace("rate = 200.0", f"rate = {rate}")
    chance = 1.0
    for signal, (step, noise) in COARSE.items():
        text = text.replace(f'"{signal}"', f'"{signal}"\nnoise = {noise}')
        if signal.startswith(counted):
            chance *= 1.0 - 2.0 * norm.sf(0.5 * step, scale=math.sqrt(noise**2 - step**2 / 12.0))
    told = settings(open_plan(written(tmp_path, PLAIN_DBC, text)))["watchdog"]["frozen_after"]
    assert told == pytest.approx(
        math.log(WatchdogSettings().frozen_chance) / math.log(chance) / rate, abs=1e-3
    )


def test_a_slow_hand_has_a_longer_time_out_and_its_noise(tmp_path):
    text = PLAIN_MAP.replace("rate = 200.0", "rate = 40.0").replace('"Tip1.Fz"', '"Tip1.Fz"\nnoise = 0.03')
    assert "states come at 40 Hz" in said(tmp_path, text)
    path = written(tmp_path, PLAIN_DBC, text)
    asked = {"noise": {"normal_force": 0.03}, "watchdog": {"time_out": 0.075}}
    limits = {"limits": {"max_force": 50.0}}
    assert settings(open_plan(path)) == asked | limits
    assert settings(open_plan(written(tmp_path, PLAIN_DBC, PLAIN_MAP))) == limits
