"""The hold that is looked ahead to, its crossings, and the least depth, against laws written out here."""

import math

import pytest
from scipy.optimize import brentq

from vegrip.contact.limit_surface import fast

LOAD = (0.4, 1e-3)  # [N], [N m]


@pytest.fixture
def begun(kernels, m):
    """Return elastic force [N], indentation [m] and force [N] with which a hold of the tried state begins."""
    kernels.copy_state(m)
    return kernels.begin_hold(m, kernels.TRIED0)


def model_force(kernels, m, elastic, dt):
    """Return the force [N] at an indentation a time into the hold."""

    def force(delta):
        at = kernels.TRIED0 + kernels.EFFECTS
        return kernels.advance(
            m, kernels.VALUES0, at, delta, 0.0, kernels.EXOGENOUS0, elastic, dt, kernels.TRIAL0
        )[2]

    return force


@pytest.mark.parametrize("pressed", [0.7, 1.0, 1.5])
def test_a_hold_begins_at_once_with_the_contact_as_that_indentation_makes_it(kernels, m, pressed) -> None:
    """No time passes: what has relaxed stays relaxed, and nothing more does."""
    y, ns = kernels.TRIED0, kernels.NS
    kernels.copy_state(m)
    m[y + kernels.DELTA] *= pressed
    m[y + kernels.SPEED] = 0.0
    depth, (_, elastic, force, _) = m[y + kernels.DELTA], kernels.contact(m, y)
    states = m[kernels.TRIAL0 : kernels.TRIAL0 + ns].copy()
    assert kernels.begin_hold(m, y) == pytest.approx((elastic, depth, force), rel=1e-12)
    assert m[y + kernels.EFFECTS : y + kernels.EFFECTS + ns] == pytest.approx(states, rel=1e-12)
    assert kernels.contact(m, y)[2] == pytest.approx(force, rel=1e-12)


@pytest.mark.parametrize("dt", [0.01, 0.5])
@pytest.mark.parametrize("drive", [0.0, 300.0, 5000.0, math.inf])
def test_force_and_indentation_go_on_along_the_stiffness_of_the_drive(kernels, m, begun, drive, dt) -> None:
    elastic, origin, fresh = begun
    m[kernels.SET_HOLD] = drive
    force_at = model_force(kernels, m, elastic, dt)
    expected = origin
    if drive < math.inf:
        expected = brentq(lambda d: fresh - force_at(d) - drive * (d - origin), 0.5 * origin, 2.0 * origin)
    delta, _, _, force = kernels.try_hold(m, kernels.TRIED0, elastic, dt, (origin, fresh))
    assert delta == pytest.approx(expected, rel=1e-6)
    assert force == pytest.approx(force_at(delta), rel=1e-12)
    trial = m[kernels.TRIAL0 : kernels.TRIAL0 + kernels.NS].tolist()
    kernels.keep_hold(m, kernels.TRIED0, delta)
    at = kernels.TRIED0 + kernels.EFFECTS
    assert m[kernels.TRIED0 + kernels.DELTA] == delta
    assert m[at : at + kernels.NS].tolist() == trial


@pytest.mark.parametrize("stiffness", [1e-3, 1.0, 1e3])
def test_a_light_touch_is_held_as_exactly_as_a_firm_one(kernels, m, monkeypatch, stiffness) -> None:
    """A force ``K d^1.5`` of which a fifth relaxes is held by ``d = d_0 / 0.8^(2/3)``, whatever K is."""

    def force_at(_m, _values, _at, delta, *_):
        elastic = stiffness * delta**1.5
        return 0.0, elastic, 0.8 * elastic, 0.0

    monkeypatch.setattr(kernels, "advance", force_at)
    m[kernels.SET_HOLD], m[kernels.TRIED0 + kernels.DELTA] = 0.0, 1.0
    delta, _, _, force = kernels.try_hold(m, kernels.TRIED0, stiffness, 0.5, (1.0, stiffness))
    assert force == pytest.approx(stiffness, rel=1e-7)
    assert delta == pytest.approx(0.8 ** (-2.0 / 3.0), rel=1e-7)


def test_a_load_needs_a_contact_that_has_force_and_area(kernels) -> None:
    assert kernels.gauge_of(2.0, 3e-3, 2.5, 0.5, LOAD) == fast.gauge(2.5, 0.4, 1e-3 / 3e-3)
    for force, radius in ((0.0, 3e-3), (2.0, 0.0), (-1.0, 3e-3)):
        assert kernels.gauge_of(force, radius, 2.5, 0.5, LOAD) == math.inf
        assert kernels.gauge_of(force, radius, 2.5, 0.5, (0.0, 1e-3)) == math.inf
        assert kernels.gauge_of(force, radius, 2.5, 0.5, (0.0, 0.0)) == 0.0


def test_what_does_not_come_from_the_force_of_the_gauge_is_kept_apart(kernels, m) -> None:
    m[kernels.REP_FORCE], m[kernels.REP_FORCE_STD], m[kernels.REP_GAUGE_REL] = 0.5, 0.05, 0.26
    m[kernels.REP_GAUGE_BY_FORCE] = 0.0
    m[kernels.FRI_VAR] = m[kernels.CONSIDER0 + kernels.CONSIDERED_MU] = alone = 0.04
    assert kernels.variance_without_force(m, 0.5) == pytest.approx(0.26**2 - 0.1**2)
    m[kernels.REP_GAUGE_BY_FORCE] = 0.16
    assert kernels.variance_without_force(m, 0.5) == pytest.approx(0.26**2 - 0.16**2)
    m[kernels.REP_GAUGE_REL] = 0.09
    assert kernels.variance_without_force(m, 0.5) == alone
    for force, std, relative in ((0.0, 0.05, 0.2), (0.5, 0.5e6, 0.2), (0.5, 0.05, 1e6)):
        m[kernels.REP_FORCE], m[kernels.REP_FORCE_STD], m[kernels.REP_GAUGE_REL] = force, std, relative
        assert kernels.variance_without_force(m, 0.5) == pytest.approx(alone)
    m[kernels.FRI_EXPONENT_VAR], tenfold = 0.01, math.log(50.0 / 5.0)
    assert kernels.variance_without_force(m, 50.0) == pytest.approx(alone + 0.01 * tenfold**2)


def test_an_error_of_the_force_and_of_what_follows_it_matters_less_at_a_larger_force(kernels, m) -> None:
    m[kernels.REP_FORCE], m[kernels.REP_FORCE_STD], m[kernels.REP_GAUGE_REL] = 0.5, 0.05, 0.26
    m[kernels.REP_GAUGE_BY_FORCE] = 0.16
    assert kernels.spread_by_force(m, 0.5) == pytest.approx(0.16)
    assert kernels.spread_by_force(m, 2.0) == pytest.approx(0.04)
    m[kernels.REP_GAUGE_BY_FORCE] = 0.0
    assert kernels.spread_by_force(m, 2.0) == pytest.approx(0.025)
    for unknown in (math.inf, 1e6):
        m[kernels.REP_GAUGE_REL] = m[kernels.REP_GAUGE_BY_FORCE] = unknown
        assert kernels.spread_by_force(m, 2.0) == pytest.approx(0.025)


@pytest.mark.parametrize("torque", [0.0, 1e-3])
@pytest.mark.parametrize("force", [0.8, 1.5])
def test_the_bound_of_a_gauge_widens_by_what_relaxes_and_by_the_noise_of_the_load(
    kernels, m, monkeypatch, force, torque
) -> None:
    monkeypatch.setattr(kernels, "variance_without_force", lambda *_: 0.04)
    monkeypatch.setattr(kernels, "upper_gauge", lambda *given: given[:3])
    m[kernels.REP_FORCE_STD], m[kernels.SET_S_TANGENTIAL], m[kernels.SET_S_TORQUE] = 0.1, 0.02, 6e-5
    fresh, a, mu = 0.95, 3e-3, 0.5
    _, relative, noise = kernels.bound_gauge(m, 0.7, force, a, mu, fresh, (0.4, torque), 1.6)
    lost = 0.3 * math.log(fresh / force)
    assert relative == pytest.approx(math.sqrt(0.04 + (0.1 / force) ** 2 + lost**2))
    assert noise == pytest.approx(math.hypot(0.02, 0.02 if torque else 0.0) / (mu * force))
    assert kernels.bound_gauge(m, 0.7, force, a, mu, 0.0, (0.4, torque), 1.6)[1] == pytest.approx(
        math.sqrt(0.04 + (0.1 / force) ** 2)
    )


@pytest.mark.parametrize("at", [0.013, 0.5, 1.0])
def test_a_crossing_is_found_within_its_step(kernels, m, monkeypatch, at) -> None:
    def probability(_m, _y, _before, dt, _begun, _load):
        return (0.3 if dt >= at else 0.1), 9.0, 9.0

    monkeypatch.setattr(kernels, "slip_probability_after", probability)
    found = kernels.crossing_time(m, kernels.TRIED0, 1.0, 1.0, (1e-3, 1.0), LOAD, 0.2)
    assert at <= found <= at + 2e-9


@pytest.mark.parametrize(
    ("earliest", "likely", "sliding", "told"),
    [
        (0.37, 41.0, 0.0, (41.0, 0.37)),
        (0.0004, 0.0004, 0.0, (0.0004, 0.0004)),
        (-1.0, 5.0, 0.0, (5.0, 0.0)),
        (-1.0, -1.0, 0.0, (0.0, 0.0)),
        (3.0, 1e5, 0.0, (math.inf, 3.0)),
        (1e5, 1e5, 0.0, (math.inf, math.inf)),
        (3.0, 2.2e4, 0.0, (2.2e4, 3.0)),
        (3.0, 3e4, 0.0, (math.inf, 3.0)),
        (3.0, 41.0, 1.0, (0.0, 0.0)),
        (math.nan, math.nan, 0.0, (math.nan, math.nan)),
    ],
)
def test_a_hold_is_followed_until_slip_is_likely(
    kernels, m, monkeypatch, earliest, likely, sliding, told
) -> None:
    """Slip has the chance 0.1 from one instant on, and one half from another."""
    passed = [0.0, 0.0]  # [s] of the hold that is kept, and tried beyond it

    def probability(_m, _y, before, dt, begun, load):
        assert (begun, load) == ((2e-3, 1.5), (0.4, 1e-3))
        assert before == (7.0 if passed[0] == 0.0 else 8.0)
        passed[1] = dt
        t = passed[0] + dt
        return (0.5 if t >= likely else 0.1 if t >= earliest else 0.0 * likely), 3e-3, 8.0

    monkeypatch.setattr(kernels, "slip_probability_after", probability)
    monkeypatch.setattr(kernels, "begin_hold", lambda *_: (7.0, 2e-3, 1.5))
    monkeypatch.setattr(kernels, "keep_hold", lambda *_: passed.__setitem__(0, sum(passed)))
    for place in (kernels.FRI_SLIDING, kernels.REP_SLIDES):
        m[kernels.FRI_SLIDING] = m[kernels.REP_SLIDES] = 0.0
        m[place], m[kernels.REP_CONTACT], passed[:] = sliding, 1.0, [0.0, 0.0]
        found = kernels.slip_times(m, -0.4, -1e-3, 0.1)
        assert found == pytest.approx(told, rel=1e-6, nan_ok=True)
        assert [one == 0.0 for one in found] == [one == 0.0 for one in told]
    assert all(math.isnan(one) for one in kernels.slip_times(m, math.nan, 1e-3, 0.1))
    m[kernels.REP_CONTACT] = 0.0
    assert all(math.isnan(one) for one in kernels.slip_times(m, 0.4, 1e-3, 0.1))


@pytest.mark.parametrize("power", [1.0, 1.5, 2.0, 4.0])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
def test_the_least_depth_is_where_the_worst_gauge_is_what_is_wanted(
    kernels, m, monkeypatch, power, share
) -> None:
    radius, asked = m[kernels.SET_TIP_RADIUS], []

    def worst(_m, _y, depth, load, quantile):
        assert (load, quantile) == (LOAD, 1.6)
        asked.append(depth)
        return math.nan if depth < 1e-3 * radius else 0.8 * (share * radius / depth) ** power

    monkeypatch.setattr(kernels, "worst_gauge", worst)
    for present in (0.0, 0.05 * radius, 0.7 * radius):
        asked.clear()
        found = kernels.least_depth(m, kernels.TRIED0, LOAD, 0.8, present, 1.6)
        assert share * radius * (1.0 - 1e-9) <= found <= share * radius * (1.0 + 2e-6)
        assert len(asked) <= (25 if present == 0.0 else 14)


@pytest.mark.parametrize("below", [math.nan, math.inf])
@pytest.mark.parametrize("jump", [1e-6, 0.02, 0.9])
def test_a_gauge_that_jumps_to_none_is_held_from_the_jump_on(kernels, m, monkeypatch, jump, below) -> None:
    """And where there is no load at all, at the least depth that is looked at: e^-19 of the deepest."""
    radius = m[kernels.SET_TIP_RADIUS]
    monkeypatch.setattr(kernels, "worst_gauge", lambda *given: below if given[2] < jump * radius else 0.0)
    found = kernels.least_depth(m, kernels.TRIED0, LOAD, 0.8, 0.3 * radius, 1.6)
    assert jump * radius <= found <= jump * radius * (1.0 + 2e-6)
    monkeypatch.setattr(kernels, "worst_gauge", lambda *_: 0.0)
    found = kernels.least_depth(m, kernels.TRIED0, LOAD, 0.8, 0.3 * radius, 1.6)
    assert found == pytest.approx(kernels.DEEPEST * radius * math.exp(-19.0), rel=2e-6)


@pytest.mark.parametrize(("hold", "horizon"), [(0.0, 2.0), (500.0, 0.0), (500.0, 2.0)])
def test_the_worst_gauge_is_the_greatest_over_parts_of_the_horizon(
    kernels, m, monkeypatch, hold, horizon
) -> None:
    m[kernels.SET_HOLD], m[kernels.SET_HORIZON] = hold, horizon
    steps = []

    def after(_m, _y, before, dt, begun, load, quantile):
        assert (begun, load, quantile) == ((1e-3, 1.5), LOAD, 1.6)
        steps.append((before, dt))
        return [0.2, 0.5, 0.9, 0.4, 0.3][len(steps) - 1], 2e-3, 8.0

    monkeypatch.setattr(kernels, "gauge_after", after)
    monkeypatch.setattr(kernels, "begin_hold", lambda *_: (7.0, 1e-3, 1.5))
    monkeypatch.setattr(kernels, "keep_hold", lambda *_: None)
    worst = kernels.worst_gauge(m, kernels.TRIED0, 1e-3, LOAD, 1.6)
    if hold == 0.0 or horizon == 0.0:
        assert (worst, steps) == (0.2, [(7.0, 0.0)])
        return
    assert worst == 0.9
    assert [before for before, _ in steps] == [7.0, 7.0, 8.0, 8.0, 8.0]
    assert [dt for _, dt in steps] == pytest.approx([0.0, 0.2, 0.3, 0.5, 1.0])


@pytest.mark.parametrize(
    ("pressed", "margin", "wanted"),
    [(0.5, 0.5, 0.5), (0.501, 0.5, None), (0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.001, 0.0, None),
     (0.0, 0.999, 0.001), (0.0, 1.0, None), (0.0, 1.5, None)],
)  # fmt: skip
def test_no_force_suffices_where_the_deepest_press_does_not_or_all_of_the_surface_is_to_stay_unused(
    kernels, m, monkeypatch, pressed, margin, wanted
) -> None:
    asked = []
    monkeypatch.setattr(kernels, "load_to_hold", lambda _m, tangential, torque: (tangential, torque))
    monkeypatch.setattr(kernels, "worst_gauge", lambda _m, _y, depth, *_: asked.append(depth) or pressed)
    monkeypatch.setattr(kernels, "least_depth", lambda *given: asked.append(given[3:]) or 1e-3)
    monkeypatch.setattr(kernels, "begin_hold", lambda m, y: (9.0, 9.0, 1e3 * m[y + kernels.DELTA]))
    found = kernels.least_force(m, 0.3, 0.0, margin, 1.6)
    assert found == (math.inf if wanted is None else pytest.approx(1.0))
    if wanted is not None:
        assert asked[1] == pytest.approx((wanted, m[kernels.Y0 + kernels.DELTA], 1.6))


@pytest.mark.parametrize(("force", "asks"), [(0.7, 1), (0.0, 0)])
def test_a_gauge_after_a_hold_is_bounded_where_there_is_a_contact(
    kernels, m, monkeypatch, force, asks
) -> None:
    asked = []
    monkeypatch.setattr(kernels, "try_hold", lambda *_: (2e-3, 7.0, 8.0, force))
    monkeypatch.setattr(kernels, "surface_of", lambda *_: (3e-3, 2.5, 0.5))
    monkeypatch.setattr(kernels, "bound_gauge", lambda _m, *given: asked.append(given) or 0.9)
    found = kernels.gauge_after(m, kernels.TRIED0, 9.0, 0.1, (1e-3, 0.9), LOAD, 1.6)
    assert found == (0.9 if asks else math.inf, 2e-3, 8.0)
    g = fast.gauge(2.5, 0.4 / 0.35, 1e-3 / (0.35 * 3e-3))
    assert asked == [(pytest.approx(g), force, 3e-3, 0.5, 0.9, LOAD, 1.6)] * asks


@pytest.mark.parametrize("torque", [0.0, 1e-3])
def test_the_chance_of_slip_is_that_of_the_utilisation_after_the_hold_and_what_is_not_sure_of_it(
    kernels, m, monkeypatch, torque
) -> None:
    begun, load, force, a, k, mu = (1e-3, 0.9), (0.4, torque), 0.7, 3e-3, 2.5, 0.5
    held, asked = [2e-3, 7.0, 8.0, force], []
    monkeypatch.setattr(kernels, "try_hold", lambda *given: asked.append(given[2:]) or held)
    monkeypatch.setattr(kernels, "surface_of", lambda _m, *given: asked.append(given) or (a, k, mu))
    monkeypatch.setattr(kernels, "onset_probability", lambda _m, *given: asked.append(given) or 0.3)
    m[kernels.SET_S_TANGENTIAL], m[kernels.SET_S_TORQUE], m[kernels.FRI_LN_MU] = 0.02, 6e-5, -0.4
    found = kernels.slip_probability_after(m, kernels.TRIED0, 9.0, 0.1, begun, load)
    assert found == (0.3, 2e-3, 8.0)
    assert asked[:2] == [(9.0, 0.1, begun), (2e-3, 7.0, 8.0, force)]
    g = fast.gauge(k, 0.4 / (mu * force), torque / (mu * force * a))
    noise = math.hypot(0.02, 0.02 if torque else 0.0) / (mu * force) / g
    unsure = math.hypot(0.3 * math.log(0.9 / force), noise)
    assert asked[2] == pytest.approx((g * math.exp(-0.4), unsure, math.log(force / 5.0)))
    kernels.slip_probability_after(m, kernels.TRIED0, 9.0, 0.1, (1e-3, 0.0), load)
    assert asked[-1][1] == pytest.approx(noise)
    held[3] = 0.0
    assert kernels.slip_probability_after(m, kernels.TRIED0, 9.0, 0.1, begun, load)[0] == 1.0


def test_the_reserve_is_what_the_least_force_of_now_leaves(kernels, m, monkeypatch) -> None:
    asked = []

    def least_force(m, *given):
        asked.append((m[kernels.SET_HOLD], *given))
        return 2.0

    monkeypatch.setattr(kernels, "least_force", least_force)
    m[kernels.SET_HOLD], m[kernels.REP_FORCE] = 500.0, 3.5
    assert kernels.force_reserve(m, 0.3, 1e-3) == 1.5
    assert asked == [(0.0, 0.3, 1e-3, 0.0, m[kernels.SET_QUANTILE])]
    assert m[kernels.SET_HOLD] == 500.0
