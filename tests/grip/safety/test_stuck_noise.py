"""A live sensor shows its noise; when that vanishes it is stuck, and it takes a handful of states to see."""

import itertools
import math

import numpy as np
import pytest

from tests.grip.stages import KERNELS, StuckNoise

CHANCE = 1e-7
STEP = 0.002  # [N] on the wire
OF_EACH = ("REPEATS", "TURNS", "NOISE_COUNT")
CHANNEL = 2  # the second tangential force, as an example


def judged(values, chance=CHANCE, **of):
    """Return for each value whether the noise had vanished with it."""
    watch = StuckNoise(**of)
    return [watch.vanished(float(value), chance) for value in values]


def sensor(true, noise, seed=0, step=STEP):
    """Return what a sensor of white ``noise`` [N] and resolution ``step`` [N] says of ``true`` [N]."""
    rng = np.random.default_rng(seed)
    return np.round((true + noise * rng.standard_normal(len(true))) / step) * step


@pytest.mark.parametrize(("noise", "within"), [(0.01, 12), (0.005, 17), (0.1, 9)])
@pytest.mark.parametrize("stuck", [0.0, 3.0, 10.0])
def test_a_noisy_sensor_that_is_stuck_is_seen_within_some_states(noise, within, stuck):
    found = judged([*sensor(np.full(600, 3.0), noise), *[stuck] * 40])
    assert not any(found[:600])
    assert found[600:].index(True) <= within
    assert all(found[600 + within :]), "until it moves again"


@pytest.mark.parametrize("channel", ["tangential_force_x", "tangential_force_y", "torque_z"])
def test_a_tangential_force_that_is_stuck_is_seen_while_the_finger_presses(channel):
    """At 500 Hz: after 0.25 s, which is longer than a message of its own may be late."""
    values = [*sensor(np.full(600, 1.0), 0.01), *[1.1] * 200]
    found = judged(values, channel=channel)
    assert not any(found[:726])
    assert all(found[727:])
    assert not any(judged(values, channel=channel, pressed=0.28))  # in the air a sensor may say nothing
    assert not any(judged([*values[:600], *[0.0] * 200], channel=channel))  # which may be its dead zone


def test_no_other_channel_is_judged_by_its_noise():
    values = [*sensor(np.full(600, 1.0), 0.01), *[1.1] * 200]
    assert not any(judged(values, channel="displacement"))


def test_the_bound_is_the_chance_of_so_many_repeats():
    """p = step / (2 sqrt(pi) noise) for white noise in small steps; n = ln(chance) / ln(bound on p)."""
    noise = 0.01
    found = judged([*sensor(np.full(5000, 3.0), noise), *[3.0] * 40])
    p = STEP / (2.0 * math.sqrt(math.pi) * noise)
    at_least, at_most = (math.log(CHANCE) / math.log(bound) for bound in (p, 4.0 * p))
    assert at_least <= found[5000:].index(True) + 1 <= at_most


@pytest.mark.parametrize("noise", [0.002, 0.005, 0.02])
def test_a_live_sensor_is_never_judged_stuck(noise):
    t = np.arange(60_000) / 500.0
    forces = {
        "hold": np.full(t.size, 3.0),
        "slow": 3.0 + 2.0 * np.sin(0.7 * t),
        "move and rest": 3.0 + np.clip(4.0 * np.sin(2.0 * t), -1.0, 1.0),
    }
    for i, true in enumerate(forces.values()):
        assert not any(judged(sensor(true, noise, seed=i)))


@pytest.mark.parametrize(
    "values",
    [
        np.round((3.0 + np.clip(4.0 * np.sin(np.arange(6000) / 250.0), -1.0, 1.0)) / 0.05) * 0.05,
        sensor(3.0 + np.clip(np.sin(np.arange(6000) / 250.0), -0.7, 0.7), 0.003, step=0.05),
        np.repeat(sensor(np.full(1200, 3.0), 0.01), 5),
        sensor(np.full(200, 3.0), 0.01).tolist() + [3.0] * 100,
    ],
    ids=["no noise", "coarse", "read five times as often as it measures", "not known long enough"],
)
def test_a_sensor_whose_repeats_mean_nothing_is_not_judged(values):
    assert not any(judged(values))


def test_a_sensor_that_turns_out_to_rest_is_judged_less_and_less():
    """Should the rule be wrong for a sensor, it stops to be applied: runs of repeats teach."""
    rng = np.random.default_rng(3)
    noisy = sensor(np.full(600, 3.0), 0.01)
    resting = itertools.chain.from_iterable(
        [3.0 + STEP * (i % 2)] * int(rng.integers(15, 30)) for i in range(400)
    )
    found = judged([*noisy, *resting])
    assert any(found[600:1200])
    assert not any(found[3000:])


def test_missing_values_do_not_repeat_and_a_chance_of_nought_switches_it_off():
    values = sensor(np.full(600, 3.0), 0.01)
    assert not any(judged([*values, *[math.nan] * 100]))
    assert not any(judged([*values, *[3.0] * 100], chance=0.0))


@pytest.mark.parametrize(
    ("known", "longest"),
    [
        ({"REPEATS": 0.05}, 9),
        ({"REPEATS": 0.25}, 31),
        ({"REPEATS": 0.0}, 4),
        ({"REPEATS": 0.4}, 159),
        ({"REPEATS": 0.25, "RULE_FROZEN_CHANCE": 1e-3}, 14),
        ({"REPEATS": 0.25, "TURNS": 0.3, "NOISE_COUNT": 256}, 31),
        ({"REPEATS": 0.45}, math.inf),
        ({"REPEATS": 0.05, "TURNS": 0.299}, math.inf),
        ({"REPEATS": 0.05, "NOISE_COUNT": 255}, math.inf),
        ({"REPEATS": 0.05, "RULE_FROZEN_CHANCE": 0.0}, math.inf),
    ],
)
def test_so_many_repeats_have_a_chance_of_one_in_ten_million_and_are_judged_of_noise_alone(known, longest):
    """n = ln(chance) / ln(2 p + 3 sqrt(p (1 - p) / 256) + 3 / 256), rounded up; none where that is 1."""
    watch = StuckNoise()
    for name, value in {
        "RULE_FROZEN_CHANCE": CHANCE,
        "TURNS": 0.6,
        "NOISE_COUNT": 1000,
        **known,
    }.items():
        where = watch.memory.section(name) if name in OF_EACH else None
        if where is None:
            watch.memory[name] = value
        else:
            where[CHANNEL] = value
    assert KERNELS.longest_run(watch.f, watch.t, CHANNEL) == longest


def test_every_state_has_the_weight_of_all_that_came_before_it():
    """The weights are 1, 1/2, 1/3, 1/4, then 1/5 for each of three repeats, and 1/8 of what ends them."""
    watch = StuckNoise()
    for value in (1.0, 2.0, 1.0, 2.0, 2.0, 2.0, 2.0, 1.0):
        watch.vanished(value, CHANCE)
    of_force = {name: watch.memory.section(name)[0] for name in OF_EACH}
    assert of_force["NOISE_COUNT"] == 8
    assert of_force["REPEATS"] == pytest.approx((1.0 - 0.8**3) * 7.0 / 8.0)
    assert of_force["TURNS"] == pytest.approx(0.5 * 0.8**3 * 7.0 / 8.0 + 1.0 / 8.0)


def test_of_a_run_of_repeats_twice_its_limit_counts_and_no_more():
    """Each has the weight of one in 256 states, and so has what ends them."""
    for run, counted in ((3, 3), (10, 10), (100, 10)):
        watch = StuckNoise()
        for name, value in {
            "REPEAT_RUN": run,
            "REPEAT_LIMIT": 5.0,
            "NOISE_COUNT": 1000,
            "REPEATS": 0.1,
        }.items():
            watch.memory.section(name)[CHANNEL] = value
        KERNELS.learn_noise(watch.f, watch.t, CHANNEL, 1.0)
        kept = 1.0 - 1.0 / 256.0
        expected = (1.0 - 0.9 * kept**counted) * kept
        assert watch.memory.section("REPEATS")[CHANNEL] == pytest.approx(expected)
        assert watch.memory.section("NOISE_COUNT")[CHANNEL] == 1001 + run
