"""Any recording, and what makes two the same."""

import math

import numpy as np
from hypothesis import strategies as st

from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.channels import CHANNELS, NOISE_NAMES

text = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
number = st.floats(allow_infinity=False)  # NaN is a missing value


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    t = sorted(draw(st.sets(st.floats(-1e6, 1e6), min_size=1, max_size=6)))
    n = len(t)
    channels = draw(st.lists(st.sampled_from(list(CHANNELS)), min_size=1, unique=True))
    columns = {name: np.array(draw(st.lists(number, min_size=n, max_size=n))) for name in channels}
    for values in columns.values():
        values[0] = draw(st.floats(allow_nan=False, allow_infinity=False))  # all NaN: not measured
    return Recording(
        draw(text),
        np.array(t),
        np.array(draw(st.lists(st.integers(0, 2**50), min_size=n, max_size=n)), dtype=np.int64),
        columns,
        Fingertip(draw(st.floats(1e-9, 1.0) | st.just(math.nan)), draw(text)),
        draw(st.dictionaries(st.sampled_from(NOISE_NAMES), st.floats(1e-300, 1e300))),
        draw(st.dictionaries(text, text | st.integers() | st.booleans() | st.floats(allow_nan=False))),
        draw(st.integers(0, 2**61)),
    )


def check_same(again: Recording, recording: Recording) -> None:
    """Refuse another bit of the numbers and another word beside them."""
    assert again.t.tobytes() == recording.t.tobytes()
    assert again.episode.tobytes() == recording.episode.tobytes()
    assert list(again.columns) == list(recording.columns)
    for name, values in recording.columns.items():
        np.testing.assert_array_equal(again.columns[name], values)
        assert np.signbit(again.columns[name][0]) == np.signbit(values[0])
    assert repr(again.fingertip) == repr(recording.fingertip)  # NaN is not itself
    for told in ("name", "sensors", "source", "start"):
        assert getattr(again, told) == getattr(recording, told), told
