"""Limits, balance and stillness are those of the objects, whatever comes."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.grip.kernels.conftest import FINGER
from vegrip.grip.allocation.balance import balance_forces
from vegrip.grip.layout import CHANNELS
from vegrip.grip.safety.frozen_signal import FrozenSignal
from vegrip.grip.safety.limits import LimitSettings, clamp_force, limit_force
from vegrip.grip.safety.travel import Travel
from vegrip.messages import FingertipState, Reason

LIMITS = LimitSettings()
forces = st.one_of(st.floats(-5.0, 30.0), st.sampled_from([math.nan, math.inf, -math.inf, 0.3, 15.0]))


@given(wanted=forces, held=st.floats(0.3, 15.0), dt=st.floats(-0.1, 0.5))
def test_a_force_is_limited_as_by_the_objects(kernels, wanted, held, dt) -> None:
    f = np.zeros(FINGER.n_reals)
    f[kernels.RULE_MIN_FORCE], f[kernels.RULE_MAX_FORCE] = LIMITS.min_force, LIMITS.max_force
    f[kernels.RULE_RAISE_RATE], f[kernels.RULE_LOWER_RATE] = LIMITS.raise_rate, LIMITS.lower_rate
    f[kernels.GRIP_HELD] = held
    assert kernels.clamped(f, wanted) == clamp_force(wanted, LIMITS)
    force, reason = kernels.limited(f, wanted, int(Reason.RAISE), dt)
    assert (force, Reason(reason)) == limit_force(wanted, Reason.RAISE, held, dt, LIMITS)


@given(
    needs=st.lists(st.one_of(st.floats(0.0, 9.0), st.just(math.nan)), min_size=1, max_size=5),
    thumb=st.integers(-1, 4),
)
def test_a_grasp_balances_as_by_the_objects(kernels, needs, thumb) -> None:
    thumb = min(thumb, len(needs) - 1)
    f, t, g = np.zeros(FINGER.n_reals), np.zeros(200, np.int64), np.full(len(needs), 99.0)
    t[kernels.SETUP_FINGERS], t[kernels.SETUP_THUMB] = len(needs), thumb
    for i, need in enumerate(needs):
        t[kernels.SETUP_FINGER] = i
        f[kernels.GRIP_REQUIRED], t[kernels.TURN_STARTED] = need, 0 if math.isnan(need) else 1
        kernels.tell_need(f, t, g)
    known = {str(i): need for i, need in enumerate(needs) if not math.isnan(need)}
    expected = balance_forces(known, str(thumb))
    for name, force in expected.items():
        t[kernels.SETUP_FINGER] = int(name)
        assert kernels.shared_force(t, g) == pytest.approx(force, rel=1e-12)


@given(
    st.lists(
        st.tuples(*[st.sampled_from([0.0, 1.0, math.nan])] * 3, st.integers(1, 10**9)),
        min_size=1,
        max_size=12,
    )
)
def test_channels_are_still_as_long_as_for_the_objects(kernels, changes) -> None:
    f, t = np.full(FINGER.n_reals, math.nan), np.zeros(200, np.int64)
    names = CHANNELS[: kernels.MECHANICAL]
    every, force, now = FrozenSignal(*names), FrozenSignal("normal_force"), 0
    travel = Travel(0.3, 10**8)
    f[kernels.RULE_STUCK_TRAVEL], f[kernels.RULE_DOUBT_AFTER] = 0.3, 1e8
    for normal_force, displacement, torque, wait in changes:
        now += wait
        state = FingertipState(
            now, "tip", 0, normal_force, torque_z=torque, displacement=displacement, tangential_force_x=2.0
        )
        f[kernels.STATE0 : kernels.STATE0 + len(CHANNELS)] = [getattr(state, name) for name in CHANNELS]
        assert kernels.all_still(f, t, now) == every.duration(state, now)
        still = kernels.force_still(f, t, now)
        assert still == force.duration(state, now)
        passed = wait if t[kernels.INPUT_IS_HEARD] else 0
        assert kernels.has_travelled(f, t, now, still) == travel.is_proven(state, now, passed, still)
        t[kernels.INPUT_HEARD], t[kernels.INPUT_IS_HEARD] = now, 1
