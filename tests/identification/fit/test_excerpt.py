"""What is used of a recording that is too long to be fitted whole."""

import numpy as np
import pytest

from vegrip.identification.fit import excerpt
from vegrip.identification.fit.excerpt import EXCERPT, MOST_ROWS
from vegrip.identification.recording import Fingertip, Recording

RADIUS = 8e-3


def contacts(rows: int, rate: float, of_episode: int | None) -> Recording:
    """Return a contact every 4 s, the last 1.5 s of it in the air, and after each minute 3 s of air."""
    t = np.arange(rows) / rate
    minute = t % 60.0
    away = (minute % 4.0 > 2.5) | (minute > 57.0)
    depth = np.where(away, -1e-3, 1e-3)
    episode = np.zeros(rows, dtype=np.int64) if of_episode is None else np.arange(rows) // of_episode
    columns = {"displacement": depth, "normal_force": np.where(away, 0.0, 1.0)}
    return Recording("long", t, episode, columns, Fingertip(RADIUS), {"displacement": 1e-6})


def test_a_recording_that_can_be_fitted_is_used_whole() -> None:
    whole = contacts(MOST_ROWS, 500.0, 2000)
    assert excerpt(whole) is whole
    few = contacts(MOST_ROWS + 1, 500.0, MOST_ROWS // 2)  # three long episodes without a pause to cut in
    held = {**few.columns, "displacement": np.ones(len(few))}
    few = Recording("held", few.t, few.episode, held, few.fingertip)
    assert excerpt(few) is few


@pytest.mark.parametrize("of_episode", [1000, None])
def test_an_excerpt_is_whole_pieces_spread_evenly_over_the_recording(of_episode) -> None:
    whole = contacts(3 * MOST_ROWS, 500.0, of_episode)
    part = excerpt(whole)
    assert 0.25 * len(whole) < len(part) < 0.42 * len(whole)
    assert part.t.tolist() == excerpt(whole).t.tolist()
    hours = np.histogram(part.t, bins=8, range=(0.0, whole.t[-1]))[0] / (len(whole) / 8)
    assert (hours > 0.15).all()
    starts = np.flatnonzero(np.diff(part.episode, prepend=-1) != 0)
    if of_episode is None:  # cut in the longest pause near each minute
        assert set(np.round(part.t[starts] % 60.0)) <= {0.0, 58.0}
        assert (part.columns["displacement"][starts] < 0.0).all()
    else:
        assert set(np.unique(part.episode)) <= set(np.unique(whole.episode))
        assert np.isin(np.unique(part.episode, return_counts=True)[1], 1000).all()
    assert f"{len(part)} of {len(whole)} rows" in part.source[EXCERPT]
