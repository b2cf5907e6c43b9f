"""The pressure profile against the constants of [TiezziKao2007]_, Table I, to 9 digits."""

import numpy as np
import pytest

from vegrip.virtual import profile

TABLE = {1: 3.0, 2: 1.5, 3: 1.240490015, 4: 1.144139645, 7: 1.052775813, 10: 1.027441490, 50: 1.001261682}


def test_quadrature_gives_the_normalising_constants() -> None:
    k = np.array(list(TABLE), float)
    assert 1.0 / profile.share_within(k, np.ones(1))[:, 0] == pytest.approx(list(TABLE.values()), rel=1e-9)


def test_table_interpolates_the_constants() -> None:
    k = np.array(list(TABLE), float)
    assert profile.coefficient(k) == pytest.approx(list(TABLE.values()), rel=2e-6)


def test_exponent_is_the_inverse_of_the_constant() -> None:
    for k in (1.3, 2.0, 2.568902, 3.856149, 20.0):
        assert profile.exponent(float(profile.coefficient(np.array(k)))) == pytest.approx(k, rel=1e-9)


def test_creep_by_thirty_percent_gives_the_exponent_of_the_paper() -> None:
    assert profile.exponent(1.5 / 1.3) == pytest.approx(3.856149, rel=1e-5)


def test_exponent_stops_at_the_end_of_the_table() -> None:
    assert [profile.exponent(C) for C in (0.9, 1.0)] == pytest.approx([profile.EXPONENTS[-1]] * 2)


def test_hertz_share_within_a_radius_is_the_known_one() -> None:
    r = np.array([0.2, 0.5, 0.9, 1.0])
    share = 1.5 * profile.share_within(np.array([2.0]), r)[0]
    assert share == pytest.approx(1.0 - (1.0 - r**2) ** 1.5, rel=1e-9)


def test_rings_carry_the_whole_force() -> None:
    edges = tuple(np.linspace(0.0, 1.0, 9))
    shares = profile.shares_on_rings(np.array([1.0, 2.0, 3.3, 200.0]), edges)
    assert shares.sum(axis=1) == pytest.approx(1.0, rel=1e-12)
    assert np.all(shares > 0.0)


def test_a_larger_exponent_moves_the_pressure_outwards() -> None:
    edges = (0.0, 0.5, 1.0)
    inner = profile.shares_on_rings(np.array([1.5, 2.0, 4.0, 20.0]), edges)[:, 0]
    assert np.all(np.diff(inner) < 0.0)
    assert inner[-1] > 0.25  # uniform pressure would leave a quarter
