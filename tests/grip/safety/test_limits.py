"""Limits: no input whatever gets a command past them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.grip.stages import clamp_force, limit_force
from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.grip.safety import LimitSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Reason
from vegrip.runtime.lifecycle import rows

LIMITS = LimitSettings(min_force=0.5, max_force=10.0, raise_rate=40.0, lower_rate=4.0)
anything = st.floats(allow_nan=True, allow_infinity=True)


@given(wanted=anything, held=st.floats(0.5, 10.0), dt=st.floats(-1.0, 1.0))
def test_no_wanted_force_passes_magnitude_or_rate(wanted: float, held: float, dt: float) -> None:
    force, _ = limit_force(wanted, Reason.RAISE, held, dt, LIMITS)
    assert 0.5 <= force <= 10.0
    assert -4.0 * max(dt, 0.0) - 1e-12 <= force - held <= 40.0 * max(dt, 0.0) + 1e-12


@given(held=st.floats(0.5, 10.0), dt=st.floats(0.0, 1.0))
def test_a_force_that_is_not_a_number_holds(held: float, dt: float) -> None:
    assert limit_force(math.nan, Reason.RAISE, held, dt, LIMITS) == (held, Reason.UNTRUSTED)


@pytest.mark.parametrize(
    ("wanted", "held", "dt", "force", "reason"),
    [
        (5.0, 5.0, 0.01, 5.0, Reason.HOLD),
        (5.2, 5.0, 0.01, 5.2, Reason.HOLD),
        (8.0, 5.0, 0.01, 5.4, Reason.RATE_LIMIT),
        (1.0, 5.0, 0.01, 4.96, Reason.RATE_LIMIT),
        (99.0, 9.9, 1.0, 10.0, Reason.MAX_LIMIT),
        (0.0, 0.6, 1.0, 0.5, Reason.MIN_LIMIT),
    ],
)
def test_the_last_stage_that_changed_the_force_gives_the_reason(
    wanted: float, held: float, dt: float, force: float, reason: Reason
) -> None:
    got, why = limit_force(wanted, Reason.HOLD, held, dt, LIMITS)
    assert got == pytest.approx(force)
    assert why == reason


def test_limits_narrowed_while_running_hold_at_once() -> None:
    assert limit_force(9.0, Reason.HOLD, 9.0, 0.0, LimitSettings(max_force=6.0)) == (6.0, Reason.MAX_LIMIT)


def test_clamping_what_is_not_a_number_gives_the_least_force() -> None:
    assert clamp_force(math.nan, LIMITS) == 0.5


def test_crossed_limits_are_refused_in_one_sentence() -> None:
    with pytest.raises(ConfigError, match="least force must not exceed the largest"):
        build(LimitSettings, {"min_force": 5.0, "max_force": 1.0}, "hand.toml [limits]")


@pytest.mark.parametrize("value", [1e308, math.inf, math.nan, -1.0, 2e5])
@pytest.mark.parametrize("name", ["max_force", "min_force", "raise_rate", "lower_rate"])
def test_a_limit_that_is_none_is_refused(name: str, value: float) -> None:
    with pytest.raises(ConfigError, match=name):
        build(LimitSettings, {name: value}, "hand.toml [limits]")


def test_every_number_that_can_be_set_while_the_node_grips_is_bounded() -> None:
    numbers = [(n, d) for n, value, d in rows(ControlSettings()) if type(value) in (int, float) and d.live]
    assert [name for name, d in numbers if not (math.isfinite(d.low) and math.isfinite(d.high))] == []
