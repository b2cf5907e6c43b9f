"""Reduced relaxation and creep as written in the paper."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from vegrip.contact.elastic import ElasticLaw, ExponentialStiffness, PowerStiffness
from vegrip.contact.hereditary import force, force_after_step
from vegrip.contact.prony import Creep, Relaxation, creep_of, relaxation_of
from vegrip.errors import DomainError

# t, g, h with c = 0.3, nu = 3.1 1/s
GOLDEN = np.array(
    [
        (0, 1, 1),
        (0.05, 0.956925, 1.043075),
        (0.1, 0.920034, 1.079966),
        (0.2, 0.861383, 1.138617),
        (0.5, 0.763674, 1.236326),
        (1, 0.713515, 1.286485),
        (2, 0.700609, 1.299391),
        (np.inf, 0.7, 1.3),
    ]
)


def test_relaxation_and_creep_have_the_golden_digits() -> None:
    t, g, h = GOLDEN.T
    assert Relaxation([0.3], [3.1])(t) == pytest.approx(g, abs=6e-7)
    assert Creep([0.3], [3.1])(t) == pytest.approx(h, abs=6e-7)


def test_any_number_of_branches_adds_up() -> None:
    c, nu = [0.1, 0.25, 0.05], [40.0, 2.0, 0.01]
    t = np.linspace(0, 50, 11).reshape(1, 11)
    written_out = 0.6 + sum(ci * np.exp(-ni * t) for ci, ni in zip(c, nu, strict=True))
    assert Relaxation(c, nu)(t) == pytest.approx(written_out, rel=1e-13)
    assert Relaxation(c, nu).equilibrium == pytest.approx(0.6)
    assert Creep(c, nu).equilibrium == pytest.approx(1.4)


def test_without_branches_the_contact_is_elastic() -> None:
    assert np.all(Relaxation([], [])(np.array([0.0, 1.0])) == 1)


@pytest.mark.parametrize(
    ("c", "nu"), [([0.3], []), ([-0.1], [1.0]), ([0.3], [0.0]), ([0.3], [np.inf]), ([0.6, 0.6], [1.0, 2.0])]
)
def test_a_relaxation_that_no_material_has_is_refused(c: list[float], nu: list[float]) -> None:
    with pytest.raises(DomainError):
        Relaxation(c, nu)


def test_a_branch_without_an_amplitude_changes_nothing() -> None:
    t = np.array([0.0, 0.3, np.inf])
    assert np.array_equal(Relaxation([0.0, 0.3], [7.0, 3.1])(t), Relaxation([0.3], [3.1])(t))


def test_time_before_the_step_is_refused() -> None:
    with pytest.raises(DomainError):
        Creep([0.3], [3.1])(-1e-3)


def test_amplitudes_may_sum_to_one_but_for_rounding() -> None:
    assert Relaxation([0.3, 0.7 + 5e-13], [1.0, 2.0]).equilibrium == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(DomainError, match="more than 1"):
        Relaxation([0.3, 0.7 + 1.5e-12], [1.0, 2.0])


PAPER = Relaxation([0.3], [3.1])
TWO = Relaxation([0.3, 0.2], [3.1, 0.25])


@st.composite
def relaxations(draw: st.DrawFn) -> Relaxation:
    shares = draw(st.lists(st.floats(0.01, 1), min_size=2, max_size=5))
    rates = draw(st.lists(st.floats(1e-2, 1e2), min_size=len(shares) - 1, max_size=len(shares) - 1))
    return Relaxation([c / sum(shares) for c in shares[:-1]], rates)


def rate_of(creep: Creep, t: float) -> float:
    return sum(c * nu * np.exp(-nu * t) for c, nu in zip(creep.amplitudes, creep.rates, strict=True))


def convolved(g: Relaxation, j: Creep, t: float) -> float:
    """``int_0^t g(t-s) dj(s)``, the step of ``j`` at zero included."""
    edges = np.unique(
        np.concatenate([[0, t], t - np.minimum(t, 1 / np.array(g.rates)), 3 / np.array(j.rates)])
    )
    edges = edges[edges <= t]
    return float(g(t)) + sum(
        quad(lambda s: float(g(t - s)) * rate_of(j, s), a, b, limit=200)[0] for a, b in pairwise(edges)
    )


def test_one_branch_has_the_closed_form() -> None:
    j = creep_of(PAPER)
    assert j.amplitudes == pytest.approx([0.428571], abs=6e-7)
    assert j.rates == pytest.approx([2.17], abs=1e-12)


def test_two_branches_have_the_golden_digits() -> None:
    j = creep_of(TWO)
    assert j.rates == pytest.approx([0.176672176, 2.193327824], abs=6e-10)
    assert j([0.5, 5, np.inf]) == pytest.approx([1.316173309, 1.751274871, 2], abs=6e-10)


def test_golden_creep_of_the_paper_relaxation() -> None:
    t = [0, 0.05, 0.1, 0.2, 0.5, 1, 2, np.inf]
    j = creep_of(PAPER)(t)
    golden = [1, 1.044066, 1.083601, 1.150895, 1.283756, 1.379638, 1.422984, 1.428571]
    assert j == pytest.approx(golden, abs=6e-7)
    golden = [1, 1.029166, 1.054985, 1.098223, 1.181195, 1.239301, 1.265125, 1.268434]
    assert j ** (2 / 3) == pytest.approx(golden, abs=6e-7)


@settings(max_examples=20)
@given(relaxations(), st.floats(0.01, 10))
def test_any_conjugate_pair_convolves_to_one(g: Relaxation, t: float) -> None:
    assert convolved(g, creep_of(g), t) == pytest.approx(1, abs=1e-7)


@given(relaxations(), st.floats(1e-3, 1e3))
def test_laplace_transforms_are_reciprocal(g: Relaxation, s: float) -> None:
    j = creep_of(g)
    s_g = g.equilibrium + sum(c * s / (s + nu) for c, nu in zip(g.amplitudes, g.rates, strict=True))
    s_j = 1 + sum(c * nu / (s + nu) for c, nu in zip(j.amplitudes, j.rates, strict=True))
    assert s_g * s_j == pytest.approx(1, rel=1e-9)


@given(relaxations())
def test_conjugation_undoes_itself(g: Relaxation) -> None:
    times = np.geomspace(1e-3, 1e3, 13)
    assert relaxation_of(creep_of(g))(times) == pytest.approx(g(times), abs=1e-10)


@given(relaxations())
def test_creep_grows_to_the_inverse_of_what_stays(g: Relaxation) -> None:
    j = creep_of(g)
    assert j(np.inf) == pytest.approx(1 / g.equilibrium, rel=1e-9)
    assert min(j.rates) > 0
    assert min(j.amplitudes) >= 0


def test_the_pair_of_the_paper_is_not_conjugate() -> None:
    h = Creep([0.3], [3.1])
    assert convolved(PAPER, h, 20.0) == pytest.approx(0.91, abs=1e-9)
    g = relaxation_of(h)
    assert (g.equilibrium, *g.amplitudes, *g.rates) == pytest.approx((0.769231, 0.230769, 4.03), abs=6e-7)


def test_a_fluid_is_refused() -> None:
    with pytest.raises(DomainError, match="falls to zero"):
        creep_of(Relaxation([0.4, 0.6], [1.0, 2.0]))
    with pytest.raises(DomainError, match="falls to zero"):
        creep_of(Relaxation([1.0 - 0.9e-12], [1.0]))
    assert creep_of(Relaxation([1.0 - 1.1e-12], [1.0]))(np.inf) == pytest.approx(1.0 / 1.1e-12, rel=1e-3)


def test_elastic_contacts_are_their_own_conjugate() -> None:
    assert creep_of(Relaxation([], []))(5.0) == 1


G = Relaxation([0.3], [3.1])

# force after a ramp of unit speed for one second, m = 1
RAMPS = [
    (PowerStiffness(1, 0), 0.7924145933),
    (ExponentialStiffness(1, 0), 0.7924145933),
    (PowerStiffness(1, 1), 0.4169630344),
    (ExponentialStiffness(1, 1), 1.3983996672),
]
ramps = pytest.mark.parametrize(("law", "golden"), RAMPS, ids=repr)


@ramps
def test_recursion_gives_the_golden_ramp(law: ElasticLaw, golden: float) -> None:
    t = np.linspace(0, 1, 60_001)
    assert force(t, t, law, G)[-1] == pytest.approx(golden, abs=6e-11)


def test_a_linear_law_needs_one_step_for_the_golden_ramp() -> None:
    assert force([0, 1], [0, 1], PowerStiffness(1, 0), G)[-1] == pytest.approx(0.7924145933, abs=6e-11)


@pytest.mark.parametrize("law", [PowerStiffness(1, 1), ExponentialStiffness(1, 1)], ids=repr)
def test_a_curved_law_converges_with_the_square_of_the_step(law: ElasticLaw) -> None:
    exact, _ = quad(lambda s: float(G(1 - s) * law.stiffness(s)), 0, 1, epsabs=1e-14)
    errors = []
    for n in (50, 100):
        t = np.linspace(0, 1, n + 1)
        errors.append(abs(force(t, t, law, G)[-1] - exact))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.02)


@given(st.floats(1e-5, 5e-3), st.floats(0, 100))
def test_a_first_sample_is_a_step(delta: float, t: float) -> None:
    law = PowerStiffness(4e4, 0.5)
    held = force([0.0, t], [delta, delta], law, G)
    assert held[0] == pytest.approx(float(law.force(delta)), rel=1e-13)
    assert held[1] == pytest.approx(float(force_after_step(t, delta, law, G)), rel=1e-12)


def test_a_sphere_relaxes_by_the_same_factor_at_any_depth() -> None:
    law = PowerStiffness(4e4, 0.5)
    depths = np.array([[1e-4], [1e-3], [3e-3]])
    t = np.linspace(0, 2, 9)
    held = force(t, np.repeat(depths, 9, axis=1), law, G)
    assert held / held[:, :1] == pytest.approx(np.tile(G(t), (3, 1)), rel=1e-12)


@given(st.lists(st.floats(0, 1e-3), min_size=2, max_size=9))
def test_pressing_only_deeper_never_lowers_the_force_below_what_stays(rises: list[float]) -> None:
    law = PowerStiffness(4e4, 0.5)
    delta = np.cumsum(rises)
    pressed = force(np.arange(len(delta)) * 0.1, delta, law, G)
    assert np.all(pressed >= 0.7 * law.force(delta) - 1e-12)
    assert np.all(pressed <= law.force(delta) + 1e-12)
