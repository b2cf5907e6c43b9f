"""What slip, its absence and a part of the load that is gone say, by the integrals that they stand for."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ndtr
from scipy.stats import norm

BASE, VAR, SCATTER = -0.3, 0.04, 0.0025


def put(kernels, m, **given) -> None:
    """Set numbers of friction by name."""
    for name, value in given.items():
        m[getattr(kernels, f"FRI_{name.upper()}")] = value


def of(kernels, m, *names):
    found = tuple(float(m[getattr(kernels, f"FRI_{name.upper()}")]) for name in names)
    return found if len(names) > 1 else found[0]


@pytest.fixture
def f(kernels, m):
    """Give a belief of friction in a new loading."""
    put(kernels, m, base_ln=BASE, base_var=VAR, ln_mu=BASE, var=VAR, scatter_var=SCATTER, events=0.0,
        best=0.0, peak=0.0, proven=0.0, sliding=0.0, slide_count=0.0, slide_mean=0.0, unconfirmed=math.inf,
        held_time=0.0, held_least=0.0, smooth=0.0, touching=1.0, exponent=0.0, exponent_var=0.0, cov=0.0,
        base_exponent=0.0, base_exponent_var=0.0, base_cov=0.0, load=0.0)  # fmt: skip
    m[kernels.SET_MU_PRIOR_VAR], m[kernels.SET_MU_DRIFT], m[kernels.SET_REGRASP] = 0.16, 0.0, 0.0
    m[kernels.SET_SCATTER] = 0.05
    return m


@pytest.mark.parametrize("z", [-30.0, -8.001, -7.999, -2.0, 0.0, 1.5, 6.0])
def test_the_ratio_of_mills_is_that_of_the_normal_law(kernels, z) -> None:
    assert kernels.inverse_mills(z) == pytest.approx(math.exp(norm.logpdf(z) - norm.logcdf(z)), rel=1e-3)
    assert kernels.upper_tail(z) == pytest.approx(ndtr(-z), rel=1e-12)
    assert kernels.upper_tail(60.0) == 1e-300


@pytest.mark.parametrize("u", [0.3, 0.74, 1.2])
def test_not_slipping_leaves_the_moments_of_the_belief_times_its_likelihood(kernels, f, u) -> None:
    noise = 0.01

    def weight(x):
        return norm.pdf(x, BASE, math.sqrt(VAR)) * norm.cdf((x - math.log(u)) / math.sqrt(noise))

    total, first, second = (
        quad(lambda x, n=n: x**n * weight(x), -2.5, 2.5, points=[BASE])[0] for n in range(3)
    )
    kernels.update_by_stick(f, u, noise)
    mean, var, proven = of(kernels, f, "ln_mu", "var", "proven")
    assert mean == pytest.approx(first / total, abs=1e-7)
    assert var == pytest.approx(second / total - (first / total) ** 2, rel=1e-5)
    assert proven == u


LOAD, EXPONENT, EXPONENT_VAR, COV = 0.8, 0.2, 0.02, -0.01


def of_load(kernels, f) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Let friction fall with the load; return mean and covariance of (ln mu, g), and what a load looks at."""
    law = {"exponent": EXPONENT, "exponent_var": EXPONENT_VAR, "cov": COV}
    put(kernels, f, load=LOAD, **law, **{f"base_{name}": value for name, value in law.items()})
    return np.array([BASE, EXPONENT]), np.array([[VAR, COV], [COV, EXPONENT_VAR]]), np.array([1.0, -LOAD])


def believed(kernels, f) -> tuple[np.ndarray, np.ndarray]:
    ln_mu, g, var, cov, g_var = of(kernels, f, "ln_mu", "exponent", "var", "cov", "exponent_var")
    return np.array([ln_mu, g]), np.array([[var, cov], [cov, g_var]])


def test_a_slide_at_a_load_is_a_linear_observation_of_friction_and_its_exponent(kernels, f) -> None:
    """Kalman's update in two dimensions; the first slide learns nothing of the scatter."""
    mean, p, h = of_load(kernels, f)
    kernels.update_by_slip(f, -0.9, SCATTER, True)
    gain = p @ h / (h @ p @ h + SCATTER)
    found, covariance = believed(kernels, f)
    assert found == pytest.approx(mean + gain * (-0.9 - h @ mean))
    assert covariance == pytest.approx(p - np.outer(gain, h @ p))


def test_a_load_that_held_leaves_the_moments_of_the_belief_times_its_likelihood_at_every_load(
    kernels, f
) -> None:
    """By sampling the half-plane: 400 000 draws."""
    mean, p, h = of_load(kernels, f)
    ln_u, noise = -0.4, 0.003
    kernels.update_by_stick(f, math.exp(ln_u + EXPONENT * LOAD), noise)
    z = np.random.default_rng(1).multivariate_normal(mean, p, 400_000)
    weight = ndtr((z @ h - ln_u) / math.sqrt(noise))
    found, covariance = believed(kernels, f)
    assert found == pytest.approx(np.average(z, axis=0, weights=weight), abs=2e-3)
    assert covariance == pytest.approx(np.cov(z.T, aweights=weight), abs=4e-4)


def test_what_was_learned_at_one_load_is_known_less_well_at_another(kernels, f) -> None:
    of_load(kernels, f)
    put(kernels, f, load=-0.5, cov=0.0, base_cov=0.0)
    kernels.update_by_slip(f, -0.2, SCATTER, True)
    spread = [kernels.friction_variance(f, load) for load in (-0.5, 0.0, 1.1)]
    assert spread[0] < spread[1] < spread[2]
    assert spread[2] == pytest.approx(EXPONENT_VAR * 1.6**2 + SCATTER, rel=0.15)


@pytest.mark.parametrize("exponent", [0.0, 0.3, 1.0])
@pytest.mark.parametrize(
    ("force", "counts"), [(0.01, 0.1), (0.15, 0.15), (5.0, 5.0), (99.0, 99.0), (150.0, 100.0)]
)
def test_friction_falls_by_a_power_of_the_load_between_a_tenth_and_a_hundred_newtons(
    kernels, f, exponent, force, counts
) -> None:
    put(kernels, f, exponent=exponent)
    assert kernels.relative_load(force) == pytest.approx(math.log(counts / 5.0))
    assert kernels.friction_factor(f, force) == pytest.approx((counts / 5.0) ** -exponent)


def test_a_belief_keeps_a_variance_and_evidence_that_is_all_of_it_is_not_taken_off(kernels, f) -> None:
    for var, left in ((VAR, 1e-8), (1e-9, 1e-9)):
        put(kernels, f, base_var=var)
        kernels.observe_base(f, 0.1, 1.0 / var)
        assert of(kernels, f, "var", "exponent_var") == (left, 0.0)
    put(kernels, f, var=VAR)
    for left, known in ((1.1e-3, VAR / 1.1e-3), (0.9e-3, VAR)):
        kernels.remove_site(f, 0.0, (1.0 - left) / VAR, -30.0)
        assert of(kernels, f, "base_var") == pytest.approx(known)
    put(kernels, f, base_ln=7.0)
    kernels.remove_site(f, 0.0, 0.0, -30.0)
    assert of(kernels, f, "base_ln", "base_var") == (of(kernels, f, "ln_mu"), VAR)


@pytest.mark.parametrize("exponent_var", [0.0, EXPONENT_VAR, 1.0])
def test_the_variance_at_a_load_is_that_of_the_line(kernels, f, exponent_var) -> None:
    cov = -0.5 * math.sqrt(VAR * exponent_var)
    put(kernels, f, var=VAR, exponent_var=exponent_var, cov=cov)
    put(kernels, f, base_var=VAR, base_exponent_var=exponent_var, base_cov=cov)
    h = np.array([1.0, -LOAD])
    expected = h @ np.array([[VAR, cov], [cov, exponent_var]]) @ h
    assert kernels.friction_variance(f, LOAD) == pytest.approx(expected)
    assert kernels.base_variance(f, LOAD) == pytest.approx(expected)


def test_taking_the_evidence_of_a_loading_off_gives_the_belief_before_it(kernels, f) -> None:
    mean, p, h = of_load(kernels, f)
    precision, weighted = 40.0, -30.0
    after = np.linalg.inv(np.linalg.inv(p) + precision * np.outer(h, h))
    moved = after @ (np.linalg.solve(p, mean) + weighted * h)
    put(kernels, f, ln_mu=moved[0], exponent=moved[1], var=after[0, 0], cov=after[0, 1],
        exponent_var=after[1, 1])  # fmt: skip
    kernels.remove_site(f, LOAD, precision, weighted)
    before = of(kernels, f, "base_ln", "base_exponent", "base_var", "base_cov", "base_exponent_var")
    assert before == pytest.approx((*mean, p[0, 0], p[0, 1], p[1, 1]))


@pytest.mark.parametrize(
    ("best", "proven", "u", "news"),
    [(0.5, 0.0, 0.516, True), (0.5, 0.0, 0.515, False), (0.0, 0.5, 0.5, False), (0.0, 0.5, 0.51, True)],
)
def test_a_load_that_was_held_before_is_no_news(kernels, f, best, proven, u, news) -> None:
    put(kernels, f, best=best, proven=proven)
    kernels.update_by_stick(f, u, 0.01)
    assert (of(kernels, f, "ln_mu") > BASE) == news


def test_a_slide_is_a_measurement_and_its_scatter_is_learned_from_the_second_on(kernels, f) -> None:
    noise, off = 0.0125, -0.5
    kernels.update_by_slip(f, BASE + off, noise, True)
    gain = VAR / (VAR + noise)
    assert of(kernels, f, "ln_mu", "var") == pytest.approx((BASE + gain * off, (1.0 - gain) * VAR))
    assert of(kernels, f, "events", "scatter_var", "sliding") == (1.0, SCATTER, 1.0)
    kernels.update_by_slip(f, BASE + off, noise, True)
    excess = off**2 - VAR - (noise - SCATTER)
    scatter = SCATTER + (excess - SCATTER) / 4.0  # that was told is worth three slides
    assert of(kernels, f, "events", "scatter_var") == pytest.approx((2.0, scatter))
    gain = VAR / (VAR + noise + scatter - SCATTER)
    assert of(kernels, f, "ln_mu") == pytest.approx(BASE + gain * off)
    kernels.update_by_slip(f, BASE + off, noise, False)  # the same slide, better averaged
    assert of(kernels, f, "events", "scatter_var") == pytest.approx((2.0, scatter))
    kernels.update_by_slip(f, BASE, noise, True)
    assert of(kernels, f, "scatter_var") == pytest.approx(scatter * (1.0 - 1.0 / 5.0))


def test_a_slide_counts_from_three_samples_on_while_the_load_stays(kernels, f) -> None:
    noise, at = 0.01, BASE - 0.2
    for ln_u in (at - 0.1, at + 0.1):
        kernels.count_slide(f, ln_u, noise)
        assert of(kernels, f, "ln_mu") == BASE
    kernels.count_slide(f, at + 0.3, noise)
    gain = VAR / (VAR + noise)
    assert of(kernels, f, "ln_mu") == pytest.approx(BASE + gain * (at + 0.1 - BASE))
    assert of(kernels, f, "slide_count", "events") == (3.0, 1.0)
    kernels.count_slide(f, at + 0.1 + 0.405, noise)  # 0.1 and three deviations: another friction
    assert of(kernels, f, "slide_count") == -1.0
    for _ in range(9):
        kernels.count_slide(f, at, noise)
    assert of(kernels, f, "slide_count", "events") == (-1.0, 1.0)


@pytest.mark.parametrize(("off", "counts"), [(0.395, True), (0.405, False), (-0.395, True), (-0.405, False)])
def test_a_slide_goes_on_within_a_tenth_and_three_deviations(kernels, f, off, counts) -> None:
    put(kernels, f, slide_count=2.0, slide_mean=-0.6)
    kernels.count_slide(f, -0.6 + off, 0.01)
    assert of(kernels, f, "slide_count") == (3.0 if counts else 0.0)


@pytest.mark.parametrize(
    ("stds", "before", "believed"),
    [
        (2.49, math.inf, True),
        (2.51, math.inf, False),
        (3.0, 0.19, True),
        (3.0, -0.19, True),
        (3.0, 0.21, False),
        (-9.0, math.inf, True),
    ],
)
def test_a_slide_far_above_the_belief_waits_for_another_like_it(kernels, f, stds, before, believed) -> None:
    ln_u = BASE + stds * math.sqrt(VAR + 0.01)
    put(kernels, f, unconfirmed=ln_u + before)
    assert kernels.is_confirmed(f, ln_u, 0.01) == believed
    assert of(kernels, f, "unconfirmed") == (ln_u if stds > 2.5 else math.inf)


def test_the_least_load_of_eleven_tenths_of_a_second_is_proven(kernels, f) -> None:
    for k in range(10):
        kernels.count_stick(f, 0.1, 0.7 if k == 3 else 0.8, 0.01)
        assert of(kernels, f, "proven") == 0.0
    kernels.count_stick(f, 0.10001, 0.9, 0.01)
    assert of(kernels, f, "proven", "held_time") == (0.7, 0.0)
    kernels.count_stick(f, 0.1, 0.9, 0.01)
    assert of(kernels, f, "held_least") == 0.9
    put(kernels, f, held_time=0.0, proven=0.0)
    for proven in (0.0, 0.9):
        kernels.count_stick(f, 0.55, 0.9, 0.01)
        assert of(kernels, f, "proven") == proven


def test_the_next_loading_begins_when_the_load_has_fallen_to_half(kernels, f) -> None:
    put(kernels, f, ln_mu=-0.1, var=0.01, peak=0.8, proven=0.6, best=0.5)
    kernels.follow_loading(f, 0.4)
    assert of(kernels, f, "peak", "base_ln") == (0.8, BASE)
    kernels.follow_loading(f, 0.39)
    assert of(kernels, f, "peak", "base_ln", "base_var", "best", "proven") == (0.39, -0.1, 0.01, 0.6, 0.0)
    kernels.follow_loading(f, 0.7)
    assert of(kernels, f, "peak") == 0.7


@pytest.mark.parametrize(("scatter", "share"), [(0.0025, 1.0), (0.01, 1.0), (0.000625, 0.25)])
def test_friction_is_forgotten_with_time_and_every_contact(kernels, f, scatter, share) -> None:
    f[kernels.SET_MU_DRIFT], f[kernels.SET_REGRASP] = 0.02, 0.06
    put(kernels, f, touching=0.0, scatter_var=scatter, ln_mu=-0.1, var=0.03)
    kernels.inflate_friction(f, 2.0, False)
    assert of(kernels, f, "var", "base_var", "base_ln") == pytest.approx((0.0308, VAR + 0.0008, BASE))
    kernels.inflate_friction(f, 0.0, True)
    grown = 0.0308 + share * 0.0036
    assert of(kernels, f, "var", "base_var", "base_ln") == pytest.approx((grown, grown, -0.1))
    kernels.inflate_friction(f, 0.0, True)
    assert of(kernels, f, "var") == pytest.approx(grown)
    kernels.inflate_friction(f, 1e9, True)
    assert of(kernels, f, "var", "base_var") == (0.16, 0.16)
    put(kernels, f, var=0.2)  # wider already
    kernels.inflate_friction(f, 1e9, True)
    assert of(kernels, f, "var", "base_var") == (0.2, 0.16)


@pytest.mark.parametrize(
    ("given", "counts"),
    [
        ({}, True),
        ({"u": math.nan}, False),
        ({"u": 0.0}, False),
        ({"u": math.inf}, False),
        ({"relative_std": 0.1}, True),
        ({"relative_std": 0.101}, False),
        ({"slip": 0.2}, False),
        ({"slip": math.nan}, False),
        ({"touching": False}, False),
        ({"sound": False}, False),
    ],
)
def test_what_is_not_known_shows_nothing(kernels, f, given, counts) -> None:
    put(kernels, f, held_time=0.5, held_least=0.5, slide_count=2.0)
    sample = {"dt": 0.01, "u": 0.6, "relative_std": 0.02, "slip": 0.0, "touching": True, "sound": True}
    kernels.learn_friction(f, **sample | given)
    assert of(kernels, f, "held_time") == pytest.approx(0.51 if counts else 0.0)
    assert of(kernels, f, "slide_count") == 0.0


@pytest.mark.parametrize(("relative", "counts"), [(9.9, 1.0), (10.0, 0.0)])
def test_a_slip_at_a_load_that_is_not_known_to_ten_times_itself_is_none(kernels, f, relative, counts) -> None:
    put(kernels, f, held_time=0.5)
    kernels.learn_friction(f, 0.01, 0.6, relative, 1.0, True, True)
    assert of(kernels, f, "slide_count", "held_time") == (counts, 0.0)


def test_a_slide_far_above_the_belief_teaches_when_a_second_one_confirms_it(kernels, f) -> None:
    ln_u = BASE + 3.0 * math.sqrt(VAR + 0.01)
    for events in (0.0, 1.0):
        put(kernels, f, slide_count=0.0)
        for count in range(3):
            assert of(kernels, f, "slide_count") == float(count)
            kernels.count_slide(f, ln_u, 0.01)
        assert of(kernels, f, "slide_count", "events") == (3.0 if events else -1.0, events)


def test_a_load_that_is_held_counts_at_the_reference_load(kernels, f) -> None:
    put(kernels, f, exponent=0.3, load=0.8)
    for u in (0.6, 0.5):
        kernels.learn_friction(f, 0.5, u, 0.02, 0.0, True, True)
        assert of(kernels, f, "smooth") == pytest.approx(u * math.exp(0.24))


def test_a_light_touch_begins_what_is_held_anew_and_a_new_contact_all_of_a_loading(kernels, f) -> None:
    put(kernels, f, smooth=0.4, held_time=0.5)
    kernels.learn_friction(f, 0.01, 0.6, 0.2, 0.0, True, True)
    assert of(kernels, f, "smooth", "held_time") == (0.0, 0.0)
    put(kernels, f, smooth=0.4, sliding=1.0, slide_count=2.0, touching=0.0, loadings=4.0)
    kernels.inflate_friction(f, 0.01, True)
    names = ("smooth", "sliding", "slide_count", "touching", "loadings")
    assert of(kernels, f, *names) == (0.0, 0.0, 0.0, 1.0, 5.0)


def test_what_a_slide_and_a_hold_show_is_told_to_those_who_share_it(kernels, f) -> None:
    put(kernels, f, best=0.5, peak=0.5, proven=0.5)
    kernels.update_by_slip(f, -0.9, 0.01, True)
    assert of(kernels, f, "event", "event_ln_u", "event_noise") == (1.0, -0.9, 0.01)
    assert of(kernels, f, "best", "peak", "proven") == (0.0, 0.0, 0.0)
    kernels.update_by_stick(f, 0.7, 0.02)
    assert of(kernels, f, "event", "event_ln_u", "event_noise") == (2.0, math.log(0.7), 0.02)


def test_the_mean_over_what_is_not_sure_of_a_load_is_that_of_five_nodes(kernels) -> None:
    nodes, weights = np.polynomial.hermite_e.hermegauss(5)
    expected = np.column_stack([nodes, weights / weights.sum()])[2:]
    assert np.array(kernels.NODES) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("load", [-0.7, 0.8])
def test_slip_is_as_likely_as_at_the_load_at_which_friction_is_as_large(kernels, f, load) -> None:
    """At mu ~ N^-g what utilises u at one load utilises u exp(g l) at the reference load."""
    put(kernels, f, peak=0.5, exponent=0.3)
    told = kernels.onset_probability(f, 0.7, 0.05, load)
    assert 0.01 < told < 0.99
    assert told == pytest.approx(kernels.onset_probability(f, 0.7 * math.exp(0.3 * load), 0.05, 0.0))


def test_slip_counts_by_the_noise_of_the_load_and_the_scatter_and_a_peak_of_noise_is_no_evidence(
    kernels, f
) -> None:
    for _ in range(3):
        kernels.learn_friction(f, 0.002, 0.6, 0.2, 1.0, True, True)
    noise = 0.2**2 + SCATTER
    assert of(kernels, f, "var") == pytest.approx(VAR * noise / (VAR + noise))
    kernels.learn_friction(f, 0.002, 0.6, 0.02, 0.0, True, True)  # the slide is over
    assert of(kernels, f, "sliding", "base_ln") == (0.0, of(kernels, f, "ln_mu"))
    assert of(kernels, f, "smooth") == pytest.approx(0.6 * (1.0 - math.exp(-0.1)))  # of 20 ms
    assert of(kernels, f, "peak") == of(kernels, f, "smooth")


@pytest.mark.parametrize("unsure", [0.0, 0.05, 0.3])
@pytest.mark.parametrize("peak", [0.0, 0.5, 0.75, 60.0])
@pytest.mark.parametrize("u", [0.45, 0.7, 0.9, 1.4, 70.0])
def test_the_probability_of_slip_is_that_of_a_law_cut_off_at_what_was_held(
    kernels, f, u, peak, unsure
) -> None:
    put(kernels, f, peak=peak)
    spread = kernels.onset_spread(f, 0.0)
    assert spread >= math.sqrt(VAR + SCATTER)
    known = (math.log(peak) - BASE) / spread if peak > 0.0 else -math.inf
    shift = max(known - 8.0, 0.0)  # what holds more shows that the belief was wrong

    steps = np.linspace(-8.0, 8.0, 4001) if unsure > 0.0 else np.zeros(1)
    weights = np.exp(-0.5 * steps**2)
    x = (math.log(u) + unsure * steps - BASE) / spread - shift
    slipped = np.where(x > known - shift, 1.0 - ndtr(-x) / ndtr(shift - known), 0.0)
    told = kernels.onset_probability(f, u, unsure, 0.0)
    near = 1e-9 if unsure == 0.0 else 0.03 if peak == 0.0 else 0.12  # five nodes across an edge
    assert told == pytest.approx(float(weights @ slipped / weights.sum()), abs=near)
    assert 0.0 <= told <= 1.0
    assert kernels.onset_probability(f, 0.0, unsure, 0.0) == 0.0


@pytest.mark.parametrize("relative", [0.1, 0.5, 1e9])
def test_the_spread_of_what_slips_is_of_friction_its_scatter_and_the_rest(kernels, f, relative) -> None:
    f[kernels.REP_GAUGE_REL] = relative
    own = f[kernels.CONSIDER0 + kernels.CONSIDERED_MU]
    expected = min(max(relative**2 - own, 0.0), 100.0)
    assert kernels.onset_spread(f, 0.0) == pytest.approx(math.sqrt(VAR + SCATTER + expected))


FORCE_NOISE, TORQUE_NOISE = 0.01, 1e-4


def part(kernels, m, which):
    begin = kernels.PART0 + kernels.PART_SIZE * which
    return m[begin : begin + kernels.PART_SIZE]


def loaded(kernels, m, seconds=2.5, dt=0.01):
    """Hold 1 N and 5 mN m for a while, known to 10 mN and 0.1 mN m."""
    m[kernels.SET_S_TANGENTIAL], m[kernels.SET_S_TORQUE], m[kernels.SET_LONGEST_GAP] = (
        FORCE_NOISE,
        TORQUE_NOISE,
        0.1,
    )
    for which in (0, 1):
        part(kernels, m, which)[:] = 0.0
    for _ in range(round(seconds / dt)):
        kernels.follow_load(m, dt, 1.0, -5e-3)


@pytest.mark.parametrize(
    ("force", "torque", "doubted"),
    [
        (1.0, 2.4e-3, [False, True]),
        (1.0, 2.6e-3, [False, False]),
        (0.49, -5e-3, [True, False]),
        (0.51, 5e-3, [False, False]),
        (1.0 - 0.23, 0.0, [False, True]),
        (1.0 - 0.25, 0.0, [False, False]),  # the other does not stay
        (1.0 + 0.23, 0.0, [False, True]),
        (1.0 + 0.25, 0.0, [False, False]),
        (0.0, 0.0, [False, False]),
    ],
)
def test_a_part_that_falls_below_half_while_the_other_stays_within_a_fifth_is_doubted(
    kernels, m, force, torque, doubted
) -> None:
    """And four deviations of its noise; both are averages and least values of 1 N and 5 mN m by then."""
    loaded(kernels, m)
    kernels.follow_load(m, 0.01, force, torque)
    assert [kernels.is_part_doubted(m, which) for which in (0, 1)] == doubted
    assert kernels.is_load_doubted(m) == any(doubted)
    held = kernels.load_to_hold(m, 0.2, 1e-3)
    assert held == pytest.approx((1.0 if doubted[0] else 0.2, 5e-3 if doubted[1] else 1e-3), rel=0.01)


def test_a_doubt_ends_when_the_part_is_back_or_after_eleven_tenths_of_a_second(kernels, m) -> None:
    for value, back in ((3.4e-3, False), (3.6e-3, True)):
        loaded(kernels, m)
        kernels.follow_load(m, 0.01, 1.0, 0.0)
        kernels.follow_load(m, 0.01, 1.0, value)
        assert kernels.is_load_doubted(m) == (not back)
    loaded(kernels, m)
    lasts = 0
    kernels.follow_load(m, 0.01, 1.0, 0.0)
    while kernels.is_load_doubted(m):
        kernels.follow_load(m, 0.01, 1.0, 0.0)
        lasts += 1
    assert lasts == pytest.approx(110, abs=1)
    assert not part(kernels, m, 1).any()


@pytest.mark.parametrize("torque", [math.nan, 0.0])
def test_what_is_not_measured_or_comes_after_a_gap_is_known_anew(kernels, m, torque) -> None:
    loaded(kernels, m)
    kernels.follow_load(m, 0.01 if math.isnan(torque) else 0.11, 1.0, torque)
    assert not part(kernels, m, 1).any()
    assert not kernels.is_load_doubted(m)


def test_a_part_is_averaged_over_a_tenth_of_a_second_and_its_least_kept_for_one_to_two_blocks(
    kernels, m
) -> None:
    loaded(kernels, m, 0.0)
    kernels.note_part(m, kernels.PART0, 0.05, 3.0)
    assert m[kernels.PART0 + kernels.PART_AVERAGE] == pytest.approx(1.0)  # 0.05 / 0.15
    loaded(kernels, m, 3.3)
    at, dt = kernels.PART0, 0.01
    assert kernels.held_part(m, at) == pytest.approx(1.0, abs=1e-3)
    for _ in range(50):
        kernels.note_part(m, at, dt, 0.6)
    dip = kernels.held_part(m, at)
    assert dip == pytest.approx(0.6, abs=0.01)
    lasts = 0
    while kernels.held_part(m, at) < 0.61:
        kernels.note_part(m, at, dt, 1.0)
        lasts += 1
    assert 110 <= lasts <= 221


def test_a_part_that_is_not_felt_is_not_there(kernels, m) -> None:
    """Six deviations of its noise, and a fall of as much."""
    loaded(kernels, m, 0.0)
    at = kernels.PART0
    for average, felt in ((0.059, False), (0.061, True)):
        m[at + kernels.PART_AVERAGE] = average
        assert kernels.does_part_stay(m, 0, average, FORCE_NOISE) == felt
    for least, last, gone in (
        (0.061, 1.0, True),
        (0.059, 1.0, False),
        (1.0, 0.061, True),
        (1.0, 0.059, False),
    ):
        m[at + kernels.PART_LEAST] = m[at + kernels.PART_BEFORE] = least
        m[at + kernels.PART_LAST] = last
        assert kernels.is_gone(m, at, 0.0, FORCE_NOISE) == gone
