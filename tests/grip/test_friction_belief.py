"""The belief of the grasp is a joint Gaussian: against dense algebra, and what it must and must not do."""

import math

import numpy as np
import pytest
from scipy.stats import norm

from vegrip.grip.friction_belief import (
    absorb_factor,
    absorb_hold,
    absorb_slide,
    begin_belief,
    believed_mean,
    believed_variance,
    chance_of_change,
    clear_doubts,
    expect_exponent,
    expect_finger,
    remove_factor,
    void_slides,
    widen_belief,
    widen_own,
)
from vegrip.grip.grasp_memory import BELIEF_ROW, GraspMemory
from vegrip.types import Floats

N, LN_MU, STD, OWN, EXPONENT, EXPONENT_STD = 5, math.log(0.5), 0.35, 0.08, 0.15, 0.12


def belief(drift: float = 0.03) -> GraspMemory:
    g = GraspMemory()
    begin_belief(g, N, drift)
    expect_exponent(g, EXPONENT, EXPONENT_STD**2)
    for i in range(N):
        expect_finger(g, i, LN_MU, STD, OWN)
    return g


def mean(g: GraspMemory) -> Floats:
    return np.array(g.belief.mean[: N + 1])


def covariance(g: GraspMemory) -> Floats:
    p: Floats = np.array(g.belief.p).reshape(BELIEF_ROW, BELIEF_ROW)[: N + 1, : N + 1]
    return p


def direction(i: int, load: float) -> Floats:
    h = np.zeros(N + 1)
    h[i], h[N] = 1.0, -load
    return h


def test_the_prior_is_common_to_all_but_for_what_is_each_ones_own_and_knows_nothing_of_the_exponent() -> None:
    p = covariance(belief())
    assert np.allclose(np.diag(p)[:N], STD**2)
    assert np.allclose(p[0, 1:N], STD**2 - OWN**2)
    assert np.allclose(p[N, :N], 0.0)
    assert p[N, N] == pytest.approx(EXPONENT_STD**2)


def test_factors_are_kalman_updates_of_the_whole_vector_at_any_load() -> None:
    g, rng = belief(), np.random.default_rng(0)
    x, p = mean(g), covariance(g)
    for _ in range(30):
        i, load = int(rng.integers(N)), float(rng.uniform(-3.0, 1.5))
        y, r = float(rng.normal(-0.7, 0.3)), float(rng.uniform(1e-3, 0.1))
        h = direction(i, load)
        gain = p @ h / (h @ p @ h + r)
        x, p = x + gain * (y - h @ x), p - np.outer(gain, h @ p)
        absorb_factor(g, i, load, 1.0 / r, y / r)
        assert np.allclose(mean(g), x)
        assert np.allclose(covariance(g), p)


def test_slides_at_two_loads_tell_the_exponent_and_one_load_does_not() -> None:
    one, two = belief(), belief()
    for g, heavy in ((one, math.log(0.6)), (two, math.log(3.0))):
        for load in (math.log(0.6), heavy):
            g.belief.load[0] = load
            for _ in range(20):
                absorb_slide(g, 0, math.log(0.4) - 0.3 * load, 1e-3)
    assert mean(two)[N] == pytest.approx(0.3, abs=0.02)
    assert covariance(two)[N, N] < 0.1 * covariance(one)[N, N]


def test_what_was_learned_at_a_light_load_is_known_less_well_at_a_heavy_one() -> None:
    g = belief()
    g.belief.load[0] = math.log(3.0 / 5.0)
    absorb_slide(g, 0, math.log(0.4), 0.0025)
    there = believed_variance(g, 0)
    g.belief.load[0] = math.log(15.0 / 5.0)
    assert believed_variance(g, 0) > 2.0 * there


def test_a_load_that_held_leaves_the_moments_of_the_truncated_belief() -> None:
    """Of the finger itself, at its load, by quadrature."""
    g, ln_u, noise = belief(), -0.9, 0.004
    g.belief.load[2] = 0.7
    before, variance = believed_mean(g, 2), believed_variance(g, 2)
    absorb_hold(g, 2, ln_u, noise)
    x = np.linspace(before - 8.0 * math.sqrt(variance), before + 8.0 * math.sqrt(variance), 40_001)
    weight = norm.pdf(x, before, math.sqrt(variance)) * norm.cdf((x - ln_u) / math.sqrt(noise))
    m = float(np.average(x, weights=weight))
    assert believed_mean(g, 2) == pytest.approx(m, abs=1e-6)
    assert believed_variance(g, 2) == pytest.approx(float(np.average((x - m) ** 2, weights=weight)), rel=1e-5)


def test_a_thousand_looks_at_one_load_are_one_piece_of_evidence() -> None:
    g = belief(drift=0.0)
    absorb_hold(g, 0, -0.9, 0.01)
    once = mean(g), covariance(g)
    for _ in range(1000):
        absorb_hold(g, 0, -0.9 + 0.019, 0.01)
    assert np.array_equal(mean(g), once[0])
    assert np.array_equal(covariance(g), once[1])


def test_a_larger_load_takes_the_place_of_what_a_smaller_one_has_shown() -> None:
    rising, at_once = belief(drift=0.0), belief(drift=0.0)
    for ln_u in np.linspace(-1.6, -0.7, 20):
        absorb_hold(rising, 1, float(ln_u), 0.01)
    absorb_hold(at_once, 1, -0.7, 0.01)
    assert np.allclose(mean(rising), mean(at_once), atol=1e-9)
    assert np.allclose(covariance(rising), covariance(at_once), atol=1e-9)


def test_one_slide_lowers_what_is_believed_of_all_fingers() -> None:
    g = belief()
    absorb_slide(g, 0, math.log(0.3), 0.01)
    assert np.all(mean(g)[:N] < LN_MU - 0.35)


def test_no_slide_moves_the_belief_by_more_than_four_standard_deviations() -> None:
    far, farther = belief(), belief()
    absorb_slide(far, 0, LN_MU - 6.0, 0.01)
    absorb_slide(farther, 0, LN_MU - 60.0, 0.01)
    assert np.allclose(mean(far), mean(farther))


def test_a_slide_whose_load_is_known_less_well_teaches_less() -> None:
    known, vague = belief(), belief()
    absorb_slide(known, 0, -1.0, 0.1**2)
    absorb_slide(vague, 0, -1.0, 0.3**2)
    assert mean(known)[0] < mean(vague)[0] < LN_MU
    assert covariance(known)[0, 0] < covariance(vague)[0, 0]


@pytest.mark.parametrize("off", [0.0, -0.3, 1.0, -2.0])
def test_the_chance_of_a_change_is_that_of_two_gaussians(off: float) -> None:
    p = 0.02 * norm.pdf(off, 0.0, math.sqrt(0.01 + 0.16))
    q = 0.98 * norm.pdf(off, 0.0, 0.1)
    assert chance_of_change(off, 0.01) == pytest.approx(p / (p + q))


def test_faces_that_got_wet_are_believed_to_be_so_after_one_slide() -> None:
    g = belief(drift=0.0)
    for _ in range(10):
        absorb_slide(g, 0, math.log(0.6), 0.01)
    absorb_slide(g, 3, math.log(0.35), 0.01)
    assert mean(g)[3] == pytest.approx(math.log(0.35), abs=0.12)
    assert mean(g)[0] < math.log(0.48)


def test_what_is_forgotten_is_never_more_than_the_prior_said() -> None:
    g = belief(drift=0.1)
    absorb_slide(g, 0, math.log(0.4), 0.001)
    for _ in range(100):
        g.belief.since += 1.0
        widen_belief(g)
    assert np.max(np.diag(covariance(g))[:N]) == pytest.approx(STD**2)


def test_a_lie_is_taken_back_for_all_fingers_but_not_what_was_low_before() -> None:
    g = belief(drift=0.0)
    absorb_slide(g, 0, math.log(0.3), 0.01)
    clear_doubts(g)
    before, known = mean(g).copy(), covariance(g).copy()
    g.belief.load[0] = 1.0
    absorb_slide(g, 0, math.log(0.15), 0.01)
    absorb_slide(g, 1, math.log(0.1), 0.01)
    void_slides(g)
    assert (mean(g) == before).all()
    assert (covariance(g) == known).all()
    absorb_hold(g, 0, math.log(0.4), 0.01)
    held = mean(g).copy()
    void_slides(g)  # nothing is in doubt
    assert (mean(g) == held).all()


def test_what_fingers_hold_counts_anew_once_friction_has_changed() -> None:
    """Dry, finger 1 has held 0.5; then finger 0 slides at 0.15. That finger 1 holds 0.3 now is news."""
    g, other = belief(), belief()
    for one in (g, other):
        absorb_hold(one, 1, math.log(0.5), 0.01)
    absorb_slide(g, 0, math.log(0.15), 0.01)
    before = believed_mean(g, 1)
    absorb_hold(g, 1, math.log(0.3), 0.01)
    assert believed_mean(g, 1) > before + 0.1
    before = believed_mean(other, 1)
    absorb_hold(other, 1, math.log(0.3), 0.01)
    assert believed_mean(other, 1) == before


def test_friction_that_is_stated_stays_as_stated_whatever_time_and_others_teach() -> None:
    g = belief(drift=1.0)
    expect_finger(g, 2, LN_MU, 0.0, OWN)
    for _ in range(20):
        g.belief.since = 1.0
        widen_belief(g)
        absorb_slide(g, 0, math.log(0.2), 0.01)
    assert believed_mean(g, 2) == LN_MU
    assert np.allclose(covariance(g)[2], 0.0)
    assert believed_mean(g, 1) < LN_MU - 0.3


def test_hostile_evidence_leaves_a_covariance() -> None:
    g, rng = belief(), np.random.default_rng(1)
    for _ in range(3000):
        i = int(rng.integers(N))
        g.belief.load[i] = float(rng.uniform(-4.0, 3.0))
        what = rng.integers(4)
        if what == 0:
            absorb_slide(g, i, float(rng.normal(-1.0, 2.0)), float(rng.uniform(1e-3, 0.2)))
        elif what == 1:
            absorb_hold(g, i, float(rng.normal(-1.0, 1.0)), float(rng.uniform(1e-3, 0.2)))
        elif what == 2:
            void_slides(g)
        else:
            g.belief.since += float(rng.exponential(2.0))
        assert np.all(np.isfinite(mean(g)))
        assert np.linalg.eigvalsh(covariance(g)).min() > -1e-9
        assert np.diag(covariance(g))[:N].max() < STD**2 * 1.6


def test_time_widens_the_belief_by_a_walk_of_which_four_fifths_are_common_to_all() -> None:
    g = belief(drift=0.03)
    absorb_slide(g, 0, math.log(0.4), 0.01)
    expected, g.belief.since = covariance(g), 2.0
    expected[:N, :N] += 0.03**2 * 2.0 * (0.8 + 0.2 * np.eye(N))
    widen_belief(g)
    assert np.allclose(covariance(g), expected, rtol=1e-12)
    assert g.belief.since == 0.0


@pytest.mark.parametrize(("precision", "part"), [(1.0, 1.0), (8.0, None), (-1.0, 0.0), (0.0, 0.0)])
def test_a_factor_is_taken_off_as_far_as_no_more_is_left_open_than_at_first(
    precision: float, part: float | None
) -> None:
    g, load = belief(drift=0.0), 0.7
    first = STD**2 + (EXPONENT_STD * load) ** 2
    absorb_factor(g, 2, load, 6.0, -0.9 * 6.0)
    h = direction(2, load)
    x, p = mean(g), covariance(g)
    variance = h @ p @ h
    part = (1.0 / variance - 1.0 / first) / precision if part is None else part
    left = 1.0 - part * precision * variance
    x = x + p @ h * part * precision * (h @ x + 0.9) / left
    p = p + np.outer(p @ h, h @ p) * part * precision / left
    remove_factor(g, 2, load, precision, -0.9 * precision)
    assert np.allclose(mean(g), x)
    assert np.allclose(covariance(g), p)


def test_a_factor_that_is_nearly_all_that_is_known_stays() -> None:
    for precision, stays in ((18.9, False), (19.1, True)):
        g = belief()
        g.belief.p[0], g.belief.prior_var = 0.05, 1e3
        remove_factor(g, 0, 0.0, precision, 0.0)
        assert (g.belief.p[0] == 0.05) == stays


def test_whatever_changes_the_belief_changes_its_version() -> None:
    g = belief()
    for change in (
        lambda: absorb_slide(g, 0, -1.0, 0.01),
        lambda: absorb_hold(g, 1, -0.7, 0.01),
        lambda: absorb_hold(g, 1, -0.7, 0.01),  # refused: what was learned alone is to be told anew
        lambda: absorb_factor(g, 1, 0.0, 1.0, -1.0),
        lambda: widen_own(g, 1, 0.01),
        lambda: widen_belief(g),
        lambda: void_slides(g),
    ):
        before = g.belief.version
        change()
        assert g.belief.version > before
