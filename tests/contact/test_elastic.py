"""Every stiffness law is four functions of each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from vegrip.contact.elastic import ElasticLaw, ExponentialStiffness, PowerStiffness
from vegrip.errors import DomainError

LAWS = [
    ExponentialStiffness(200.0, 900.0),
    ExponentialStiffness(200.0, 0.0),
    PowerStiffness(2.5e4, 0.5),
    PowerStiffness(3e2, 0.0),
    PowerStiffness(8e5, 1.3),
    PowerStiffness(1e-3, 0.5),  # an AFM tip: nN at um
]
laws = pytest.mark.parametrize("law", LAWS, ids=repr)
depths = st.floats(1e-7, 5e-3)


@laws
@given(delta=depths)
def test_force_is_the_integral_of_stiffness(law: ElasticLaw, delta: float) -> None:
    work, _ = quad(lambda d: float(law.stiffness(d)), 0, delta, epsabs=0, epsrel=1e-10, limit=200)
    assert law.force(delta) == pytest.approx(work, rel=1e-7)


@laws
@given(delta=depths)
def test_indentation_undoes_force(law: ElasticLaw, delta: float) -> None:
    assert law.indentation(law.force(delta)) == pytest.approx(delta, rel=1e-12)


@laws
@given(delta=depths)
def test_compliance_is_one_over_stiffness(law: ElasticLaw, delta: float) -> None:
    assert law.compliance(law.force(delta)) * law.stiffness(delta) == pytest.approx(1, rel=1e-12)


@laws
def test_no_indentation_gives_no_force_and_back(law: ElasticLaw) -> None:
    assert law.force(0.0) == 0
    assert law.indentation(0.0) == 0


@laws
@given(delta=depths, factor=st.floats(1.001, 10))
def test_more_indentation_gives_more_force(law: ElasticLaw, delta: float, factor: float) -> None:
    assert law.force(delta * factor) > law.force(delta)


@given(depths)
def test_a_tiny_exponent_is_continuous_with_the_linear_spring(delta: float) -> None:
    assert ExponentialStiffness(200.0, 1e-9).force(delta) == pytest.approx(200 * delta, rel=1e-9)


@laws
def test_laws_take_arrays_of_any_shape(law: ElasticLaw) -> None:
    delta = np.full((2, 3), 1e-3)
    assert law.force(delta).shape == law.indentation(delta).shape == (2, 3)


@laws
def test_a_pull_is_refused(law: ElasticLaw) -> None:
    with pytest.raises(DomainError):
        law.force(-1e-6)
    with pytest.raises(DomainError):
        law.indentation(np.nan)


@pytest.mark.parametrize(
    ("m", "b"),
    [(0.0, 1.0), (-1.0, 1.0), (1.0, -0.5), (np.nan, 0.0), (np.inf, 0.0), (1.0, np.inf)],
)
def test_parameters_without_meaning_are_refused(m: float, b: float) -> None:
    for law in (ExponentialStiffness, PowerStiffness):
        with pytest.raises(DomainError):
            law(m, b)
