"""Where the noise comes from."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.identification.fit.noise import (
    ABOUT,
    MAX_ROWS,
    Pair,
    at_rest,
    estimate_ou_noise,
    find_pairs,
    noise_of,
    noise_of_pairs,
    rough,
    spread_rows,
)
from vegrip.identification.fit.preprocess import find_events, find_spikes, preprocess
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.data import join_recordings
from vegrip.model import paper_model
from vegrip.types import Floats

WHITE, SLOW, TIME, BLUR = 3.2e-3, 5e-3, 2.0, 1.6e-6  # [N], [N], [s], [m]
HOLDS = ((0.6e-3, 15.0), (1.2e-3, 25.0), (1.6e-3, 20.0))


def test_white_noise_is_found_under_a_motion() -> None:
    t = np.arange(0.0, 20.0, 5e-3)
    values = np.sin(t) + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    assert rough(values, np.zeros(t.size)) == pytest.approx(0.01, rel=0.05)


def test_stated_noise_is_believed_unless_air_contradicts_it(bench) -> None:
    recording = bench()
    noise = noise_of(recording)
    assert noise.normal_force == recording.sensors["normal_force"]
    assert "stated" in noise.source["normal_force"]
    assert not noise.doubts
    wrong = _with_sensors(recording, {**recording.sensors, "normal_force": 1e-3})
    noise = noise_of(wrong)
    assert noise.normal_force == pytest.approx(0.01, rel=0.1)
    assert "stated" not in noise.source["normal_force"]
    assert len(noise.doubts) == 1


def test_without_a_statement_the_signals_tell(bench) -> None:
    noise = noise_of(_with_sensors(bench(), {}))
    assert noise.normal_force == pytest.approx(0.01, rel=0.2)
    assert noise.displacement == pytest.approx(5e-6, rel=0.2)
    assert "neighbouring" in noise.source["displacement"]


def test_single_wild_rows_are_taken_out_and_turns_are_not(bench) -> None:
    recording = bench()
    assert not preprocess(recording, noise_of(recording)).outliers
    force = recording.columns["normal_force"].copy()
    force[[500, 1200, 3000]] += 1.0
    wild = Recording("wild", recording.t, recording.episode, {**recording.columns, "normal_force": force},
                     recording.fingertip, recording.sensors)  # fmt: skip
    assert preprocess(wild, noise_of(wild)).outliers == {"normal_force": 3}


def test_a_step_is_no_spike() -> None:
    step = np.r_[np.zeros(20), np.ones(20)]
    assert not find_spikes(step, 0.01, np.zeros(40)).any()
    step[7] = 1.0
    assert np.flatnonzero(find_spikes(step, 0.01, np.zeros(40))).tolist() == [7]


def test_crests_of_a_fast_oscillation_are_no_spikes() -> None:
    crests = 2.0 * np.sin(0.3 * np.arange(200))  # 21 samples to a cycle, 400 times the noise
    assert not find_spikes(crests, 5e-3, np.zeros(200)).any()
    crests[[57, 120]] += 0.5
    assert np.flatnonzero(find_spikes(crests, 5e-3, np.zeros(200))).tolist() == [57, 120]


def _with_sensors(recording: Recording, sensors: dict[str, float]) -> Recording:
    return Recording(
        recording.name, recording.t, recording.episode, recording.columns, recording.fingertip, sensors
    )


def wandering_press(seed: int, *, repeated: bool, softer: float = 0.0) -> Recording:
    """Holds by a model, each twice if ``repeated`` (the second time ``softer``), under known noise."""
    rng = np.random.default_rng(seed)
    model = paper_model(0.008).with_value("K", 1.2)
    holds = [*HOLDS, *(HOLDS if repeated else ((0.8e-3, 17.0), (1.1e-3, 13.0)))]
    times, episode, depth, force = [], [], [], []
    start = 0.0
    for i, (deep, lasting) in enumerate(holds):
        t = np.arange(0.0, lasting, 0.01)
        turns = [0.0, 0.5, 1.0, lasting - 1.0, lasting - 0.5, lasting]
        d = np.interp(t, turns, [-2e-4, -2e-4, deep, deep, -2e-4, -2e-4])
        pressed = model.simulate(t, d).normal_force * (1.0 - softer * (i >= len(HOLDS)))
        times.append(t + start)
        episode.append(np.full(t.size, i))
        depth.append(d)
        force.append(pressed)
        start = times[-1][-1] + 20.0
    t = np.concatenate(times)
    slow = np.empty(t.size)
    slow[0] = SLOW * rng.standard_normal()
    for i, dt in enumerate(np.diff(t)):
        left = np.exp(-dt / TIME)
        slow[i + 1] = left * slow[i] + SLOW * np.sqrt(1.0 - left**2) * rng.standard_normal()
    columns = {
        "displacement": np.concatenate(depth) + BLUR * rng.standard_normal(t.size),
        "normal_force": np.concatenate(force) + slow + WHITE * rng.standard_normal(t.size),
    }
    return Recording("press", t, np.concatenate(episode), columns, Fingertip(0.008))


@pytest.mark.parametrize("softer", [0.0, 0.05])
def test_replicates_tell_the_noise_even_if_the_first_press_has_softened_the_tip(softer) -> None:
    found = [noise_of(wandering_press(seed, repeated=True, softer=softer)) for seed in range(3)]
    assert {one.source["slow_force"] for one in found} == {"3 pairs of replicate episodes"}
    assert np.mean([one.normal_force for one in found]) == pytest.approx(WHITE, rel=0.05)
    assert np.mean([one.displacement for one in found]) == pytest.approx(BLUR, rel=0.05)
    assert np.mean([one.slow_force for one in found]) == pytest.approx(SLOW, rel=0.2)
    assert np.exp(np.mean([np.log(one.slow_time) for one in found])) == pytest.approx(TIME, rel=0.35)


def test_without_replicates_rest_in_air_tells_it() -> None:
    found = [noise_of(wandering_press(seed, repeated=False)) for seed in range(4)]
    assert {one.source["slow_force"] for one in found} == {"scatter in air"}
    assert np.mean([one.normal_force for one in found]) == pytest.approx(WHITE, rel=0.05)
    assert np.mean([one.slow_force for one in found]) == pytest.approx(SLOW, rel=0.3)


def test_no_wandering_is_seen_where_there_is_none(bench) -> None:
    assert noise_of(bench()).slow_force == 0.0


def test_episodes_are_replicates_only_if_they_move_alike() -> None:
    recording = wandering_press(0, repeated=True)
    assert len(find_pairs(recording, BLUR)) == 3
    depth = recording.columns["displacement"].copy()
    depth[recording.episode == 3] *= 1.02
    moved = Recording(
        "moved",
        recording.t,
        recording.episode,
        {**recording.columns, "displacement": depth},
        Fingertip(0.008),
    )
    assert len(find_pairs(moved, BLUR)) == 2


def test_a_copy_of_an_episode_tells_nothing_of_the_noise_and_is_named() -> None:
    once = wandering_press(0, repeated=False)
    twice = join_recordings([once, once], "twice")
    noise = noise_of(twice)
    assert noise.normal_force == pytest.approx(noise_of(once).normal_force, rel=0.2)
    assert "is a copy of episode 0, to the last bit" in noise.doubts[0]
    assert noise_of(wandering_press(0, repeated=True)).doubts == ()


def test_what_a_pair_may_differ_by_is_no_noise() -> None:
    """A constant, a gain and a shift of the surface, of one pair alone and of each of several."""
    t = np.r_[np.arange(0.0, 8.0, 0.01), np.arange(20.0, 28.0, 0.01)]
    rows = np.split(np.arange(t.size), 2)
    pressed = np.clip(3.0 * np.sin(t), 0.0, None)
    rng = np.random.default_rng(0)
    for count in (1, 2):
        found, force = [], np.tile(pressed, 2) + WHITE * rng.standard_normal(2 * t.size)
        for rows_of in rows[:count]:
            found.append(Pair(rows_of, rows_of + t.size))
            force[rows_of] += 0.2 * len(found) + 0.05 * pressed[rows_of] + 0.03 * np.cbrt(pressed[rows_of])
        recording = SimpleNamespace(t=np.tile(t, 2), columns={"normal_force": force})
        noise = noise_of_pairs(recording, found, WHITE)
        assert noise.white == pytest.approx(WHITE, rel=0.06)
        assert noise.slow < 0.5 * WHITE


def test_a_tip_rests_where_it_moves_by_no_more_than_six_noises_from_before_to_after() -> None:
    n = 12 * ABOUT
    depth, episode, rows = np.zeros(n), np.zeros(n, dtype=int), np.ones(n, dtype=bool)
    depth[6 * ABOUT :] = 6.1 * BLUR
    recording = SimpleNamespace(columns={"displacement": depth}, episode=episode)
    rest = at_rest(recording, rows, BLUR)
    assert np.flatnonzero(~rest).tolist() == [
        *range(ABOUT), *range(5 * ABOUT, 7 * ABOUT), *range(n - ABOUT, n)
    ]  # fmt: skip
    assert at_rest(recording, rows, 1.02 * BLUR)[ABOUT:-ABOUT].all()
    episode[3 * ABOUT :] = 1
    assert not at_rest(recording, rows, BLUR)[2 * ABOUT : 4 * ABOUT].any()
    rows[ABOUT] = False
    lost = np.flatnonzero(rest & ~at_rest(recording, rows, 1e9 * BLUR))
    assert lost.tolist() == [ABOUT, *range(2 * ABOUT, 4 * ABOUT)]
    for few in (0, ABOUT, 2 * ABOUT):
        short = SimpleNamespace(columns={"displacement": depth[:few]}, episode=episode[:few])
        assert not at_rest(short, rows[:few], BLUR).any()


def test_a_loss_of_force_that_no_motion_explains_is_an_event() -> None:
    t = np.arange(0.0, 10.0, 0.01)
    first = np.r_[1.0, np.zeros(t.size - 1)]
    ramp = 1e-3 * np.minimum(t, 8.0)
    force = 0.2 * t + 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    assert not find_events(t, first, ramp, force, 1e-3)
    slipped = force - np.where(t >= 4.0, 0.2 * np.exp(-(t - 4.0) / 0.5), 0.0)
    (found,) = find_events(t, first, ramp, slipped, 1e-3)
    assert found.time == pytest.approx(4.0, abs=0.011)
    assert found.loss == pytest.approx(0.2, abs=0.02)
    assert slipped[found.end] == pytest.approx(force[found.end], abs=0.05)


def test_an_event_ends_twice_as_late_as_the_force_is_back_and_with_its_episode() -> None:
    t = np.arange(0.0, 12.0, 0.01)
    first = np.zeros(t.size)
    first[[0, 600]] = 1.0  # an episode ends at 6 s
    force, depth = 1.0 + 0.1 * t, 1e-4 * t
    torn = force.copy()
    for begin, back in ((1.0, 1.4), (3.0, 3.1), (5.5, 9.0), (9.5, 9.9)):
        inside = (t > begin + 1e-9) & (t < back - 1e-9)
        torn[inside] -= 0.4
    found = find_events(t, first, depth, torn, 1e-3)
    assert [round(t[one.begin], 2) for one in found] == [1.0, 3.0, 5.5, 9.5]
    assert [one.end for one in found] == [181, 321, 600, 1031]
    assert all(one.loss == pytest.approx(0.4, abs=0.01) for one in found)


def test_letting_go_and_pulling_off_are_no_events() -> None:
    t = np.arange(0.0, 4.0, 0.01)
    first = np.r_[1.0, np.zeros(t.size - 1)]
    depth = np.interp(t, [0.0, 1.0, 2.0, 2.2, 4.0], [0.0, 1e-3, 1e-3, -2e-4, -2e-4])
    let_go = 2e3 * np.maximum(depth, 0.0)
    assert not find_events(t, first, depth, let_go, 1e-3)
    stuck = np.where((depth <= 0.0) & (t > 1.0) & (t < 2.19), -0.2, let_go)
    assert not find_events(t, first, depth, stuck, 1e-3)


@pytest.mark.parametrize(("stretches", "length"), [(200, 1_000), (3, 70_000), (1, 200_000)])
def test_of_a_long_recording_stretches_spread_over_all_of_it_tell_the_noise(
    stretches: int, length: int
) -> None:
    first: Floats = np.tile(np.r_[1.0, np.zeros(length - 1)], stretches).astype(np.float64)
    rows = spread_rows(first)
    assert 0.9 * min(MAX_ROWS, first.size) <= rows.size <= MAX_ROWS
    assert first[rows[0]] == 1.0
    assert rows[-1] >= first.size - length
    assert np.all(np.diff(rows) > 0)
    begun = np.flatnonzero(np.diff(rows) > 1) + 1
    assert np.all(first[rows[begun]] == 1.0)  # a gap in time is always a new stretch
    y = 0.02 * np.random.default_rng(0).standard_normal(first.size)
    t: Floats = np.arange(first.size, dtype=np.float64) * 0.01
    found = estimate_ou_noise(t, first, y, np.ones((first.size, 1)), 0.03)
    assert found.white == pytest.approx(0.02, rel=0.02)
    assert found.slow == 0.0


def test_a_long_recording_that_is_in_the_air_only_at_its_end_tells_the_noise() -> None:
    n = 2 * MAX_ROWS
    y = np.full(n, np.nan)
    y[-1000:] = 0.02 * np.random.default_rng(0).standard_normal(1000)
    first, drift = np.r_[1.0, np.zeros(n - 1)], np.linspace(-0.5, 0.5, n)
    found = estimate_ou_noise(0.01 * np.arange(n), first, y, np.column_stack([np.ones(n), drift]), 0.03)
    assert found.white == pytest.approx(0.02, rel=0.05)


def test_of_many_stretches_the_first_and_the_last_are_looked_at() -> None:
    first: Floats = np.tile(np.r_[1.0, np.zeros(9)], 100).astype(np.float64)
    rows = spread_rows(first, 50)
    assert rows.size == 50
    assert rows[0] == 0
    assert rows[-1] == first.size - 1


@pytest.mark.parametrize("back", [True, False])
def test_an_event_says_when_it_begins_and_by_how_much_the_force_falls(back: bool) -> None:
    t = np.arange(0.0, 4.0, 0.01)
    first = np.r_[1.0, np.zeros(t.size - 1)]
    depth = 1e-3 + 1e-4 * t
    force = 1.0 + 0.1 * t
    force[150:] -= 0.4
    if back:
        force[250:] += 0.4
    (event,) = find_events(t, first, depth, force, 1e-3)
    assert event.begin == 149
    assert dataclasses.astuple(event)[2:] == pytest.approx((t[150], force[149] - force[150:153].min()))
    assert event.end == t.size if not back else 250 < event.end < t.size
