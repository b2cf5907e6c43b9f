"""What is told of a finger is what is believed of it, in the units and places of a message, or nothing."""

import math

import pytest

SURE = {
    "SAMPLE_BEGUN": 1, "SAMPLE_IS_INFORMED": 1, "SAMPLE_TRUSTED": 1, "SAMPLE_STAMP": 9_000_000,
    "SAMPLE_INFORMED": 4_000_000, "TURN_REPORTS": 7,
}  # fmt: skip
BELIEVED = {
    "SET_LONGEST_GAP": 0.01, "SET_QUANTILE": 1.6448536269514722, "REP_SOUND": 1.0, "REP_CONTACT": 1.0,
    "REP_GAUGE": 0.4, "REP_GAUGE_REL": 0.3, "REP_GAUGE_ABS": 0.05, "TAKEN_LOAD": 0.8, "TAKEN_TORQUE": 0.0,
    "PUBLISHED_CONFIDENCE": 0.95,
}  # fmt: skip


@pytest.fixture
def told(kernels, f, t, monkeypatch):
    """Report the margin with some numbers changed: return the bound and what was packed."""

    def report(reserve=1.5, likely=2.0, earliest=1.0, **changed):
        packed, asked = [], []
        monkeypatch.setattr(kernels, "pack_margin", lambda _, *values: packed.append(values))
        monkeypatch.setattr(kernels, "protect", lambda *_: None)
        monkeypatch.setattr(kernels, "force_reserve", lambda *_: reserve)
        monkeypatch.setattr(kernels, "slip_times", lambda *of: (asked.append(of[-1]), (likely, earliest))[1])
        for name, value in {**SURE, **BELIEVED, **changed}.items():
            (t if name in SURE else f)[getattr(kernels, name)] = value
        return kernels.report_margin(f, t, None), packed, asked

    return report


def test_the_margin_is_what_is_left_of_the_gauge_and_its_bound_what_is_left_of_the_upper_one(
    kernels, told
) -> None:
    bound, [packed], [chance] = told()
    upper = kernels.upper_gauge(0.4, 0.3, 0.05, BELIEVED["SET_QUANTILE"])
    assert bound == pytest.approx(1.0 - upper, abs=1e-12)
    seq, stamp, valid, value, std, age, lower, confidence, *rest = packed
    assert (seq, stamp, valid, confidence) == (7, 9_000_000, 1, 0.95)
    assert value == pytest.approx(0.6, abs=1e-12)
    assert lower == bound
    assert std == pytest.approx(math.hypot(0.4 * 0.3, 0.05))
    assert age == pytest.approx(5e-3)
    assert rest == [1.5, 2.0, 1.0]
    assert chance == pytest.approx(0.05)  # of the normal law beyond the quantile


@pytest.mark.parametrize("changed", [{"REP_SOUND": 0.0}, {"REP_CONTACT": 0.0}, {"REP_GAUGE": math.nan}])
def test_a_margin_that_is_not_known_is_told_as_such(told, changed) -> None:
    bound, [packed], asked = told(**changed)
    assert math.isnan(bound)
    assert packed[2] == 0
    assert all(math.isnan(packed[i]) for i in (3, 6, 8, 9, 10))
    assert packed[4] == packed[5] == math.inf
    assert not asked


@pytest.mark.parametrize(
    "changed",
    [
        {"REP_GAUGE": 4e38, "REP_GAUGE_REL": 0.0},
        {"reserve": 4e38},
        {"REP_GAUGE_ABS": 3e38},  # the bound alone is beyond: 1.6 times as much
        {"likely": 4e38},
        {"earliest": 4e38},
    ],
)
def test_what_a_single_does_not_carry_is_left_to_messages(told, changed) -> None:
    bound, packed, _ = told(**changed)
    assert bound == math.inf
    assert packed == []


def test_a_time_may_be_without_end(told) -> None:
    bound, [packed], _ = told(likely=math.inf, earliest=math.inf)
    assert math.isfinite(bound)
    assert packed[-2:] == (math.inf, math.inf)
