"""The load that fingers share, from the wrist: the gripper is taken off, and what is not known is counted."""

import math
from functools import partial

import numpy as np
import pytest

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import FingertipState
from vegrip.transport.hands.wrist_load import WristLoad, read_load

GRIPPER, OBJECT, G = 0.9, 0.5, 9.81  # [kg], [kg], [m/s^2]
PERIOD = NS // 100
B = 0.6  # two relative standard deviations of the share, 0.5 +- 0.15


def settings(**keys):
    return read_load({"from": "wrist.toml", "mass": GRIPPER, **keys}, "hand.toml [load]")


def shares(mass, *, acceleration=lambda _: 0.0, pull=lambda _: 0.0, seconds=10.0, zero=(3.0, -2.0, 1.0)):
    """Return the share of a finger over time; the object is there after two seconds.

    ``acceleration`` is of the wrist along y [m/s^2], ``pull`` a force at the object along y [N].
    """
    wrist, found = WristLoad(settings()), []
    for number in range(1, round(seconds * 100)):
        t = number / 100
        held = mass if t > 2.0 else 0.0
        late = max(t - 2.0, 0.0)
        force = (GRIPPER + held) * (-G - acceleration(late)) + pull(late)
        wrist.note(FingertipState(number * PERIOD, "tip", number, zero[2], zero[0], zero[1] + force))
        found.append(wrist.share(number * PERIOD)[0])
    return found


def test_the_weight_of_the_gripper_and_the_zero_of_the_sensor_are_taken_off():
    assert shares(0.0)[150] == pytest.approx(0.0, abs=1e-6)
    assert shares(OBJECT, seconds=25.0)[-1] == pytest.approx(0.5 * OBJECT * G, rel=1e-3)


def test_nothing_is_told_before_the_tare_and_after_a_silence():
    found = shares(OBJECT)
    assert all(math.isnan(one) for one in found[:99])
    wrist = WristLoad(settings())
    for number in range(1, 200):
        wrist.note(FingertipState(number * PERIOD, "tip", number, 1.0, 0.0, 0.0))
    assert wrist.share(199 * PERIOD)[0] == pytest.approx(0.0, abs=1e-6)
    assert math.isnan(wrist.share(199 * PERIOD + NS)[0])


KNOWN = 1400  # samples, after which the weight of the object is known


@pytest.mark.parametrize("part", [0.0, 0.5, 1.0])
def test_the_bound_holds_what_inertia_and_what_a_pull_load_the_object_with(part):
    """A share of 0.5 loads a finger with less than two standard deviations, whatever moves the object."""

    def shaken(t):
        return 3.0 * (1.0 - part) * math.sin(2.0 * math.pi * 2.0 * t)

    def pulled(t):
        return -4.0 * part if t > 4.0 else 0.0

    found = shares(OBJECT, acceleration=shaken, pull=pulled, seconds=20.0)
    times = [number / 100 - 2.0 for number in range(1, len(found) + 1)]
    true = [0.5 * abs(OBJECT * (G + shaken(t)) - pulled(t)) for t in times]
    assert all(one * (1.0 + B) >= other for one, other in zip(found[KNOWN:], true[KNOWN:], strict=True))


def test_two_standard_deviations_of_share_and_cause_together_are_exceeded_as_rarely_as_of_one():
    rng = np.random.default_rng(3)
    times, above, looks = np.arange(1, 2000) / 100 - 2.0, 0, 0
    for a, p, hertz in rng.uniform((0.0, 0.0, 1.5), (4.0, 4.0, 4.0), (60, 3)):

        def wave(t, of=1.0, hertz=hertz):
            return of * np.sin(2.0 * math.pi * hertz * t)

        found = np.array(
            shares(OBJECT, acceleration=partial(wave, of=a), pull=partial(wave, of=-p), seconds=20.0)
        )
        load = np.abs(OBJECT * (G + wave(times, a)) + wave(times, p))
        carried = load[KNOWN:, None] * rng.normal(0.5, 0.15, 200)
        above += np.count_nonzero(carried > (1.0 + B) * found[KNOWN:, None])
        looks += carried.size
    assert above / looks == pytest.approx(0.023, abs=0.012)


def test_the_share_is_uncertain_as_a_gain_is():
    assert settings().parameters == {"tangential_gain": 1.0, "tangential_gain_std": 0.3}


def twisted(reach, force, torque, arm):
    """Return the torque of a finger under a force and a couple that act ``arm`` from the sensor."""
    wrist = WristLoad(settings(reach=reach))
    about = torque + arm[0] * force[1] - arm[1] * force[0]
    for number in range(1, 3000):
        held = float(number > 200)
        stamp = number * PERIOD
        wrist.note(
            FingertipState(
                stamp, "tip", number, 1.0, 2.0 + held * force[0], held * force[1], 0.1 + held * about
            )
        )
    return wrist.share(stamp)[1]


@pytest.mark.parametrize("force", [(0.0, -5.0), (3.0, 0.0), (-2.0, 4.0)])
@pytest.mark.parametrize("reach", [(0.0, 0.0), (0.0, 0.15), (0.02, -0.1)])
def test_a_torque_about_the_closing_direction_is_that_at_the_grip_wherever_the_sensor_is(force, reach):
    assert twisted(reach, force, 0.04, reach) == pytest.approx(0.02, rel=1e-2)
    assert twisted(reach, force, 0.0, reach) == pytest.approx(0.0, abs=1e-6)


def test_a_weight_that_hangs_beside_the_grip_twists_it_by_its_arm():
    assert twisted((0.0, 0.15), (0.0, -5.0), 0.0, (0.01, 0.15)) == pytest.approx(0.5 * 0.05, rel=1e-2)


def test_without_a_reach_no_torque_is_told():
    assert math.isnan(twisted((), (0.0, -5.0), 0.1, (0.0, 0.0)))


@pytest.mark.parametrize(
    "keys",
    [
        {"reach": [0.1]},
        {"reach": [0.0, 150.0]},
        {"mass": 0.0},
        {"mass": 900.0},
        {"share": 0.0},
        {"share_std": -0.1},
    ],
)
def test_what_cannot_be_is_refused(keys):
    with pytest.raises(ConfigError, match=rf"^hand\.toml \[load\]: .*{next(iter(keys))}"):
        settings(**keys)
