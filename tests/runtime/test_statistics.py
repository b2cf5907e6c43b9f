"""Laws of the histogram."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.runtime.statistics import LONGEST, SIZE, Histogram, _bucket, _upper_edge

durations = st.lists(st.integers(0, 10**10), min_size=1, max_size=200)


@given(st.integers(0, LONGEST))
def test_a_duration_lies_in_its_bucket_and_the_bucket_is_narrow(duration):
    bucket = _bucket(duration)
    assert 0 <= bucket < SIZE
    lower = _upper_edge(bucket - 1) + 1 if bucket else 0
    assert lower <= duration <= _upper_edge(bucket)
    assert _upper_edge(bucket) - lower <= duration / 32


@given(durations, st.sampled_from([0.5, 0.9, 0.99, 1.0]))
def test_percentiles_agree_with_the_sorted_list_and_are_never_below_it(values, share):
    histogram = Histogram()
    for value in values:
        histogram.add(value)
    exact = float(np.quantile(values, share, method="inverted_cdf"))
    assert exact <= histogram.percentile(share) <= exact * (1 + 1 / 32)


def test_empty_is_not_a_number_and_clear_empties():
    histogram = Histogram()
    histogram.add(5)
    histogram.clear()
    assert math.isnan(histogram.percentile(0.5))
    assert (histogram.count, histogram.maximum) == (0, 0)


@pytest.mark.parametrize("duration", [-5, LONGEST * 2])
def test_impossible_durations_are_counted_at_the_ends(duration):
    histogram = Histogram()
    histogram.add(duration)
    assert histogram.percentile(1.0) == min(max(duration, 0), LONGEST)


@given(st.lists(st.lists(st.integers(0, 10**9), max_size=20), max_size=4))
def test_the_sum_of_histograms_is_the_histogram_of_all(parts):
    def of(durations):
        histogram = Histogram()
        for duration in durations:
            histogram.add(duration)
        return histogram

    total, whole = Histogram.sum_of(map(of, parts)), of([d for part in parts for d in part])
    assert (total.count, total.maximum) == (whole.count, whole.maximum)
    for share in (0.5, 0.99, 1.0):
        assert total.percentile(share) == pytest.approx(whole.percentile(share), nan_ok=True)
