"""How sliding rows are cut into stretches, and which rows are errors of a sensor."""

import numpy as np
import pytest

from vegrip.identification.fit.preprocess import find_spikes, stretches


def cut(t, rows, begins=(0,)):
    first = np.isin(np.arange(len(t)), begins).astype(float)
    middle, count = stretches(np.asarray(t), np.asarray(rows), first)
    return middle.tolist(), count.tolist()


def test_stretches_have_twenty_rows_at_most() -> None:
    t = 1e-4 * np.arange(60)
    assert cut(t, np.arange(5, 50)) == ([15, 35, 47], [20, 20, 5])


def test_stretches_end_where_rows_are_missing_or_an_episode_begins() -> None:
    t = 1e-4 * np.arange(60)
    assert cut(t, [3, 4, 5, 8, 9, 20]) == ([4, 9, 20], [3, 2, 1])
    assert cut(t, np.arange(4, 12), begins=(0, 7)) == ([5, 9], [3, 5])


def test_stretches_are_shorter_than_a_tenth_of_a_second() -> None:
    t = np.arange(20) / 64.0
    middle, count = cut(t, np.arange(20))
    assert count == [7, 7, 6]
    assert middle == [3, 10, 17]


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
