"""Indentation under imposed load: the consistent law, the paper's law, and where they part."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from vegrip.contact import creep
from vegrip.contact.elastic import ExponentialStiffness, PowerStiffness
from vegrip.contact.hereditary import hereditary_force
from vegrip.contact.prony import Creep, Relaxation, creep_of

G = Relaxation([0.3], [3.1])
H = Creep([0.3], [3.1])
HERTZ = PowerStiffness(4e4, 0.5)
T = np.array([0, 0.05, 0.1, 0.2, 0.5, 1, 2, np.inf])


def test_paper_radius_has_the_golden_digits() -> None:
    golden = [1, 1.021311, 1.039214, 1.067060, 1.111902, 1.134233, 1.139908, 1.140175]
    a = creep.paper_radius_after_step(T, 2.0, HERTZ, H, 8e-3)
    assert a / a[0] == pytest.approx(golden, abs=6e-7)
    assert a[0] == pytest.approx(np.sqrt(2 * 8e-3 * (1.5 * 2.0 / 4e4) ** (2 / 3)), rel=1e-13)


def test_consistent_sphere_creeps_by_the_two_thirds_power() -> None:
    golden = [1, 1.029166, 1.054985, 1.098223, 1.181195, 1.239301, 1.265125, 1.268434]
    delta = creep.indentation_after_step(T, 2.0, HERTZ, G)
    assert delta / delta[0] == pytest.approx(golden, abs=6e-7)


def test_the_paper_creep_belongs_to_a_power_that_is_not_that_of_hertz() -> None:
    power = np.log(creep_of(G)(np.inf)) / np.log(H(np.inf))
    assert power == pytest.approx(1.3595, abs=6e-5)


def test_exponential_stiffness_creeps_less_under_more_load() -> None:
    law = ExponentialStiffness(200.0, 900.0)
    ratios = [
        float(creep.indentation_after_step(5.0, N, law, G) / law.indentation(N)) for N in (0.01, 1.0, 20.0)
    ]
    assert ratios[0] == pytest.approx(float(creep_of(G)(5.0)), rel=0.01)  # linear at small load
    assert ratios[0] > 1.1 * ratios[1] > 1.1 * ratios[2] > 1.1


def test_a_step_of_load_held_agrees_with_the_history() -> None:
    t = np.linspace(0, 3, 31)
    N = np.full(31, 2.0)
    assert creep.indentation(t, N, HERTZ, G) == pytest.approx(
        creep.indentation_after_step(t, 2.0, HERTZ, G), rel=1e-12
    )
    stepped = creep.paper_indentation_after_step(t, 2.0, HERTZ, H)
    assert creep.paper_indentation(t, N, HERTZ, H) == pytest.approx(stepped, rel=1e-12)


def test_paper_creep_agrees_with_quadrature_over_the_compliance() -> None:
    law = ExponentialStiffness(200.0, 900.0)
    written, _ = quad(lambda s: float(H(1 - s) * law.compliance(4 * s)) * 4, 0, 1, epsabs=1e-14)
    t = np.linspace(0, 1, 20_001)
    assert creep.paper_indentation(t, 4 * t, law, H)[-1] == pytest.approx(written, rel=1e-8)


def test_imposed_load_agrees_with_the_differential_equation() -> None:
    g = Relaxation([0.2, 0.3], [20.0, 0.7])
    c, nu = np.array(g.amplitudes), np.array(g.rates)
    t = np.linspace(0, 3, 3001)
    N = 2 + np.sin(3 * t) - 2 * np.cos(2 * t)

    def rate(s: float, z: np.ndarray) -> np.ndarray:
        return nu * (2 + np.sin(3 * s) - 2 * np.cos(2 * s) + c @ z - z)

    z = solve_ivp(rate, (0, 3), np.zeros(2), t_eval=t, rtol=1e-10, atol=1e-12).y
    assert creep.elastic_force(t, N, g) == pytest.approx(N + c @ z, abs=1e-5)


def test_relaxation_brings_back_the_load_that_was_imposed() -> None:
    # one law is exact for linear N, the other for linear N_e: they meet with the square of the step
    worst = []
    for n in (400, 800):
        t = np.linspace(0, 2, n + 1)
        N = 2 - 2 * np.cos(4 * t)
        back = hereditary_force(t, creep.elastic_force(t, N, G), G)
        worst.append(np.max(np.abs(back - N)))
    assert worst[0] < 1e-4
    assert worst[0] / worst[1] == pytest.approx(4, rel=0.05)


def test_more_load_gives_more_indentation_in_both_laws() -> None:
    t = np.linspace(0, 1, 50)
    N = np.outer([1.0, 1.5], t)
    for delta in (creep.indentation(t, N, HERTZ, G), creep.paper_indentation(t, N, HERTZ, H)):
        assert np.all(delta[1, 1:] > delta[0, 1:])


def test_paper_radius_of_a_held_load_is_that_of_a_step() -> None:
    t = np.linspace(0, 1, 5)
    held = creep.paper_radius(t, np.full(5, 3.0), HERTZ, H, 8e-3)
    assert held == pytest.approx(creep.paper_radius_after_step(t, 3.0, HERTZ, H, 8e-3), rel=1e-12)
