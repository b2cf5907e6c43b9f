"""Drawings show round ticks within their axes, and points where they are."""

import math
import re
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from vegrip.web.axes import BOTTOM, LEFT, RIGHT, TOP, Axes, extent, log_ticks, runs, ticks

ENDS = st.floats(-1e6, 1e6)


@given(ENDS, st.floats(1e-6, 1e6))
def test_ticks_lie_within_the_axis_evenly_and_are_few(low: float, width: float) -> None:
    found = ticks((low, low + width))
    tolerance = 1e-9 * (abs(low) + width)
    assert all(low - tolerance <= tick <= low + width + tolerance for tick in found)
    assert len(found) <= 8
    steps = [b - a for a, b in pairwise(found)]
    assert not steps or max(steps) - min(steps) <= 1e-6 * max(steps) + tolerance


def test_logarithmic_ticks_are_one_two_five() -> None:
    assert log_ticks((0.9, 20.0)) == [1.0, 2.0, 5.0, 10.0, 20.0]


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=5))
def test_an_extent_is_finite_and_holds_what_is_finite(values: list[float]) -> None:
    low, high = extent([v for v in values if not math.isfinite(v) or abs(v) < 1e100])
    assert low < high
    assert all(low <= v <= high for v in values if math.isfinite(v) and abs(v) < 1e100)


def test_the_ends_of_the_axes_are_the_corners_of_the_frame() -> None:
    axes = Axes((1.0, 3.0), (-2.0, 2.0), "x [s]", "y [N]", (300, 200))
    axes.points([1.0, 3.0], [-2.0, 2.0], "blue")
    places = re.findall(r'cx="([\d.]+)" cy="([\d.]+)"', axes.svg("test"))
    assert [tuple(map(float, place)) for place in places] == [(LEFT, 200 - BOTTOM), (300 - RIGHT, TOP)]


def test_text_cannot_become_markup() -> None:
    drawn = Axes((0.0, 1.0), (0.0, 1.0), "<script>", '"><b>').svg('"><script>alert(1)</script>')
    assert "<script" not in drawn
    assert "<b>" not in drawn


def test_no_line_is_drawn_over_a_time_in_which_nothing_was_measured() -> None:
    from vegrip.web.figures import over_time

    time = [0.0, 0.1, 0.2, 3.0, 3.1, 3.2]
    names = ("measured_low", "measured_high", "model_low", "model_high")
    columns = {"time": time} | {name: [1.0] * 6 for name in names}
    told = {"columns": columns, "unit": "N", "noise": 0.1}
    whole = told | {"columns": columns | {"time": [0.1 * i for i in range(6)]}}
    blue = 'stroke="var(--blue)"'
    assert over_time("normal_force", told).count(blue) == 2
    assert over_time("normal_force", whole).count(blue) == 1


@given(st.lists(st.floats(0.0, 1e6), max_size=20, unique=True).map(sorted))
def test_runs_are_all_columns_once_and_in_their_order(times: list[float]) -> None:
    assert [t for run in runs(times) for t in times[run]] == times
