"""A recording in memory: what is refused, and how it turns into messages."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.errors import RecordingError
from vegrip.identification.recording import Recording
from vegrip.identification.recording.checks import longest_increasing


def press(**changed: object) -> Recording:
    fields: dict[str, object] = {
        "name": "press",
        "t": np.array([0.0, 0.1, 0.3]),
        "episode": np.array([0, 0, 4]),
        "columns": {"normal_force": np.array([0.0, 1.0, math.nan])},
    }
    return Recording(**(fields | changed))  # type: ignore[arg-type]


def test_rows_become_messages_with_integer_stamps() -> None:
    states = list(press().states("thumb", start=7))
    assert [s.stamp for s in states] == [7, 100_000_007, 300_000_007]
    assert [s.seq for s in states] == [0, 1, 2]
    assert states[1].normal_force == 1.0
    assert math.isnan(states[2].normal_force)
    assert math.isnan(states[0].torque_z)  # not measured is never zero


@given(st.integers(0, 10**15))
def test_a_nanosecond_stamp_survives_seconds_as_float(stamp: int) -> None:
    one = press(t=np.array([stamp / 1e9]), episode=np.zeros(1, int), columns={"slip": np.zeros(1)})
    assert one.stamps.tolist() == [stamp]


def test_episodes_are_recordings_of_their_own() -> None:
    first, second = press().episodes()
    assert (len(first), len(second), second.name) == (2, 1, "press episode 4")
    assert press().duration == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"columns": {}}, "the columns are none"),
        ({"columns": {"force": np.zeros(3)}}, "must be some of"),
        ({"sensors": {"force": 1.0}}, "unknown sensor"),
        ({"columns": {"slip": np.zeros(2)}}, "differ in length"),
        ({"t": np.array([0.0, 0.2, 0.2])}, "time does not increase"),
    ],
)
def test_what_is_not_a_recording_is_refused(changed: dict[str, object], sentence: str) -> None:
    with pytest.raises(RecordingError, match=sentence):
        press(**changed)


@given(st.lists(st.integers(-20, 20).map(float), min_size=1, max_size=12))
def test_the_longest_increasing_run_is_longest(values: list[float]) -> None:
    kept = longest_increasing(np.array(values))
    chosen = np.array(values)[kept]
    assert np.all(np.diff(kept) > 0)
    assert np.all(np.diff(chosen) > 0)
    ends = [1] * len(values)  # quadratic textbook recursion: longest run that ends at i
    for i in range(len(values)):
        ends[i] += max((ends[j] for j in range(i) if values[j] < values[i]), default=0)
    assert len(kept) == max(ends)
