"""How sliding rows are cut into stretches, and which rows are errors of a sensor."""

from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.errors import RecordingError
from vegrip.identification.fit.noise import Noise, estimate_wandering
from vegrip.identification.fit.preprocess import (
    Measured,
    _seen,
    _sliding,
    find_events,
    find_spikes,
    preprocess,
    stretches,
    tare_channels,
)
from vegrip.identification.recording import Fingertip, Recording


def cut(t, rows, begins=(0,)):
    first = np.isin(np.arange(len(t)), begins).astype(float)
    middle, count = stretches(np.asarray(t), np.asarray(rows), first)
    return middle.tolist(), count.tolist()


def test_a_slide_begins_with_one_row_and_no_stretch_is_longer_than_all_before_it_or_than_twenty() -> None:
    middle, count = cut(1e-4 * np.arange(90), np.arange(5, 80))
    assert count == [1, 1, 2, 4, 8, 16, 20, 20, 3]
    assert middle == [5, 6, 8, 11, 17, 29, 47, 67, 78]


def test_stretches_end_where_rows_are_missing_or_an_episode_begins() -> None:
    t = 1e-4 * np.arange(60)
    assert cut(t, [3, 4, 5, 8, 9, 20]) == ([3, 4, 5, 8, 9, 20], [1] * 6)
    assert cut(t, np.arange(4, 12), begins=(0, 7)) == ([4, 5, 6, 7, 8, 10, 11], [1, 1, 1, 1, 1, 2, 1])


def test_stretches_are_shorter_than_a_tenth_of_a_second() -> None:
    _, count = cut(np.arange(40) / 64.0, np.arange(40))
    assert count == [1, 1, 2, 4, 7, 7, 7, 7, 4]


def test_between_the_first_slip_and_the_slide_of_the_whole_contact_a_load_is_no_limit() -> None:
    n = 12
    slip = np.r_[np.zeros(3), np.ones(9)]
    speed = np.r_[np.zeros(7), np.full(5, 1e-3)]
    columns = {
        "normal_force": np.ones(n),
        "tangential_force_x": np.ones(n),
        "slip": slip,
        "slip_speed": speed,
    }
    noise = Noise(0.01, 1e-6)

    def rows(columns):
        return _sliding(Recording("r", np.arange(float(n)), np.zeros(n, int), columns), noise).tolist()

    assert rows(columns) == [3, 7, 8, 9, 10, 11]
    assert rows(columns | {"slip_speed": 0.0 * speed}) == list(range(3, n))  # no speed is told


def test_no_sliding_row_is_no_stretch() -> None:
    assert cut(np.arange(5.0), np.zeros(0, np.int64)) == ([], [])


T = np.arange(200)
PATHS = {
    "rest": np.zeros(200),
    "ramp": 0.5 * T,
    "turn": np.abs(T - 100.0) * 0.5,
    "fast oscillation": 40.0 * np.sin(0.9 * T),
}


@pytest.mark.parametrize("kind", PATHS)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_one_row_far_off_the_path_is_a_spike_and_the_path_is_none(kind, sign) -> None:
    values, first = PATHS[kind], (T == 0).astype(float)
    noisy = values + 0.01 * np.random.default_rng(0).standard_normal(T.size)
    assert not find_spikes(noisy, 1.0, first).any()
    for row in (2, 3, 60, 61, 196, 197):
        broken = noisy.copy()
        broken[row] += sign * 500.0
        assert np.flatnonzero(find_spikes(broken, 1.0, first)).tolist() == [row]


def test_a_jump_and_a_row_beside_the_begin_of_an_episode_are_no_spikes() -> None:
    first = (T == 0).astype(float)
    assert not find_spikes(np.where(T < 100, 0.0, 500.0), 1.0, first).any()
    broken = np.zeros(200)
    broken[50] = 500.0
    for begin in range(48, 54):
        changed = first.copy()
        changed[begin] = 1.0
        found = find_spikes(broken, 1.0, changed)
        assert found.any() == (begin not in (49, 50, 51, 52)), begin


def test_what_noise_may_do_is_no_spike_and_a_short_record_has_none() -> None:
    broken = np.zeros(200)
    broken[50] = 3.0
    assert not find_spikes(broken, 1.0, (T == 0).astype(float)).any()
    assert not find_spikes(np.array([0.0, 0.0, 500.0, 0.0]), 1.0, np.array([1.0, 0.0, 0.0, 0.0])).any()


@pytest.mark.parametrize(
    ("off", "apart", "wild"),
    [(7.9, 0.0, False), (8.1, 0.0, True), (48.5, 12.0, True), (47.5, 12.0, False)],
)
def test_a_spike_is_eight_deviations_off_and_four_times_what_its_neighbours_are_apart(
    off, apart, wild
) -> None:
    values = np.where(np.arange(21) > 10, apart, 0.0)
    values[10] = apart + off  # off the nearest of lines and cubic
    assert find_spikes(values, 1.0, (np.arange(21) == 0).astype(float)).any() == wild


def events(fall=1.0, *, slope=0.02, step=1e-5, at_fall=1e-5, begins=(0,), row=30, noise=0.01, level=2.0):
    """Return the events of a force that rises and falls at once, while the displacement goes on."""
    n = 60
    force = level + slope * np.arange(n)
    force[row + 1 :] -= fall
    moves = np.full(n, step)
    moves[row + 1] = at_fall
    first = np.isin(np.arange(n), begins).astype(float)
    return find_events(0.01 * np.arange(n), first, np.cumsum(moves), force, noise)


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ({}, True),
        ({"fall": 0.31, "slope": 0.0}, True),
        ({"fall": 0.29, "slope": 0.0}, False),  # thirty deviations of the noise
        ({"fall": 0.62, "slope": 0.05}, True),
        ({"fall": 0.58, "slope": 0.06}, False),  # ten times what is usual
        ({"at_fall": 1.99e-5}, True),
        ({"at_fall": 2.01e-5}, False),  # the drive moved
        ({"fall": 1.8, "slope": 0.0}, False),  # the contact parted
        ({"fall": 1.35, "slope": 0.0}, True),
        ({"fall": 1.45, "slope": 0.0}, False),
        ({"row": 6}, True),
        ({"row": 5}, False),  # too early to know what is usual
        ({"begins": (0, 31)}, False),  # from one episode to the next
    ],
)
def test_each_rule_of_an_event_has_its_place(given, found) -> None:
    told = events(**given)
    assert bool(told) == found
    if found:
        row = given.get("row", 30)
        assert (told[0].begin, told[0].time) == (row, pytest.approx(0.01 * (row + 1)))


def test_an_event_ends_when_twice_the_time_has_passed_in_which_the_force_came_back() -> None:
    (one,) = events(0.49, slope=0.04)  # back 13 rows after it
    assert (one.begin, one.end) == (30, 30 + 2 * 13 + 1)
    assert one.loss == pytest.approx(0.49 - 0.04)
    assert one.rows == slice(31, 57)
    (one,) = events(0.49, slope=0.04, begins=(0, 52))
    assert one.end == 52
    (one,) = events(1.0, slope=0.0)
    assert one.end == 60


NOISE = Noise(0.01, 1e-6, tangential_force=0.01, torque_z=1e-4, contact_radius=1e-5)


def recorded(n=400, **columns) -> Recording:
    t = 0.01 * np.arange(n)
    every = {"normal_force": np.ones(n), "displacement": np.full(n, 1e-4)} | columns
    return Recording("r", t, np.zeros(n, dtype=np.int64), every, Fingertip(0.01), {})


def test_rows_that_slide_do_so_under_a_force_and_a_load_that_is_known() -> None:
    n = 400
    force, slip, pull = np.ones(n), np.zeros(n), np.full(n, 0.5)
    slip[[3, 4, 5, 6]] = 1.0
    slip[7] = 0.99
    force[4], force[5], pull[6] = 0.0499, 0.0501, np.nan
    one = recorded(normal_force=force, slip=slip, tangential_force_x=pull)
    assert _sliding(one, NOISE).tolist() == [3, 5]
    assert _sliding(recorded(normal_force=force, slip=slip), NOISE).size == 0
    assert _sliding(recorded(tangential_force_x=pull), NOISE).size == 0


def test_a_radius_is_seen_where_it_and_the_force_are_more_than_five_deviations() -> None:
    n = 400
    radius, force = np.full(n, np.nan), np.ones(n)
    radius[[3, 4, 5, 6]] = [1e-3, 5.1e-5, 4.9e-5, 1e-3]
    force[6] = 0.049
    assert _seen(recorded(contact_radius=radius, normal_force=force), NOISE).tolist() == [3, 4]
    assert _seen(recorded(), NOISE).size == 0
    blind = Noise(0.01, 1e-6)
    assert _seen(recorded(contact_radius=radius, normal_force=force), blind).size == 0


@pytest.mark.parametrize(("air", "taken"), [(99, False), (100, True)])
def test_what_a_load_shows_in_air_is_taken_off_where_that_lasts(air, taken) -> None:
    depth = np.where(np.arange(400) < air, -1e-3, 1e-3)
    pull = np.where(np.arange(400) < air, 0.2, 1.0) + 0.01 * np.sin(np.arange(400))
    after, tare = tare_channels(recorded(displacement=depth, tangential_force_x=pull))
    expected = float(pull[:air].mean()) if taken else 0.0
    assert tare == ({"tangential_force_x": pytest.approx(expected)} if taken else {})
    assert after.columns["tangential_force_x"] == pytest.approx(pull - expected)
    assert np.array_equal(after.columns["normal_force"], np.ones(400))


def test_loads_at_slip_are_means_of_their_stretch() -> None:
    n = 400
    force, pull = np.arange(n, dtype=float), np.arange(n, dtype=float) ** 2
    pull[10] = np.nan
    force[20:23] = np.nan
    motion, middle, count = (
        SimpleNamespace(displacement=np.full(n, 7.0)),
        np.array([11, 21]),
        np.array([5, 3]),
    )
    pulled = recorded(tangential_force_x=pull)
    measured = Measured(pulled, NOISE, motion, np.zeros(n), force, middle, count, np.zeros(0, int), {}, {})
    told = measured.columns
    assert told["tangential_force_x"][11] == pytest.approx(np.mean([81.0, 121.0, 144.0, 169.0]))
    assert told["normal_force"][11] == pytest.approx(11.0)
    assert np.isnan(told["normal_force"][21])
    assert told["normal_force"][12] == 12.0
    assert np.all(told["displacement"] == 7.0)
    assert np.isnan(pull[10])
    assert pull[11] == 121.0


@pytest.mark.parametrize("channel", ["displacement", "normal_force"])
def test_a_recording_with_fewer_than_fifty_rows_of_a_channel_is_refused(channel) -> None:
    for rows in (49, 50):
        values = np.full(400, np.nan)
        values[:rows] = 1e-4
        one = recorded(**{channel: values})
        if rows == 50:
            preprocess(one, Noise(0.01, 0.0))
            continue
        with pytest.raises(RecordingError, match=f"fewer than 50 rows with {channel}"):
            preprocess(one, Noise(0.01, 0.0))


def test_a_few_rows_in_the_air_that_wander_have_a_noise() -> None:
    t = 0.005 * np.arange(60)
    y = np.full(60, np.nan)
    y[:30] = 0.01 * np.cumsum(np.random.default_rng(1).standard_normal(30))
    found = estimate_wandering(t, np.r_[1.0, np.zeros(59)], y, 1e-3)
    assert found.white > 0.0
