"""Force under imposed displacement: golden ramps, and quadrature of eq. (20) as it is written."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from vegrip.contact.elastic import ElasticLaw, ExponentialStiffness, PowerStiffness
from vegrip.contact.hereditary import force, force_after_step
from vegrip.contact.prony import Relaxation

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
def test_quadrature_of_the_hereditary_integral_gives_the_golden_ramp(law: ElasticLaw, golden: float) -> None:
    written, _ = quad(lambda s: float(G(1 - s) * law.stiffness(s)), 0, 1, epsabs=1e-13)
    assert written == pytest.approx(golden, abs=6e-11)


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
