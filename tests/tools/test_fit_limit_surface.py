from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import polynomial

from tools import fit_limit_surface
from vegrip.contact.limit_surface import fast, reference


def test_fit_never_falls_below_its_goal_and_is_the_best_such() -> None:
    x = np.linspace(-1, 1, 201)
    coefficients, error = fit_limit_surface.least_greatest_above(
        np.vander(x, 2, increasing=True), x**2, np.zeros_like(x)
    )
    # the lowest line above a parabola on [-1, 1] is 1, and it is 1 too high in the middle
    assert coefficients == pytest.approx([1.0, 0.0], abs=1e-6)
    assert error == pytest.approx(1.0, abs=1e-6)


def test_powers_are_the_chebyshev_sum() -> None:
    rng = np.random.default_rng(5)
    coefficients, (t, u) = rng.normal(size=(4, 6)), rng.uniform(-1, 1, (2, 20))
    powers = fit_limit_surface.as_powers(coefficients)
    assert polynomial.polyval2d(t, u, powers) == pytest.approx(
        np.polynomial.chebyshev.chebval2d(t, u, coefficients)
    )


def test_written_table_is_read_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy = tmp_path / "fast.py"
    copy.write_text(fit_limit_surface.FAST.read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(fit_limit_surface, "FAST", copy)
    tables = {
        name: np.asarray(getattr(fast, name)) for name in ("TORSION_TABLE", "RADIUS_TABLE", "SUPPORT_TABLE")
    }
    fit_limit_surface.write(tables)
    assert copy.read_text(encoding="utf-8") == Path(fast.__file__).read_text(encoding="utf-8")


def test_torsion_table_in_the_file_is_the_one_the_script_computes() -> None:
    t = np.linspace(-1, 1, 2001)
    again, in_file = (
        polynomial.polyval(t, np.asarray(powers))
        for powers in (fit_limit_surface.torsion_table(), fast.TORSION_TABLE)
    )
    # powers of high order differ more than what they add up to from one processor's rounding to another's
    assert again == pytest.approx(in_file, abs=1e-12)


def test_a_small_fit_lies_inside_the_surface_by_at_most_what_it_says_at_every_sample() -> None:
    k, d = fit_limit_surface.sample_points(6, 16)
    assert k.shape == d.shape == (6, 24)
    assert np.array_equal(d[0], np.sort(d[0]))
    assert 1.0 / k[[0, -1], 0] == pytest.approx([0.0, 1.0], abs=1e-9)
    # as dense in the direction of the slip as 16 even steps from pure torsion to pure force, and around d = 1
    assert np.diff(np.arctan(d[0])).max() == pytest.approx(np.pi / 34)
    assert d[0].min() == pytest.approx(np.tan(np.pi / 34))
    assert 1.0 / d[0].max() == pytest.approx(np.tan(np.pi / 34))
    assert np.count_nonzero(np.abs(d[0] - 1.0) <= 0.5 + 1e-12) > 8
    f, m = reference.point(k, d)
    torsion = m / reference.torsion_limit(k)
    table, error = fit_limit_surface.fit(1.0 / k, f, torsion, 1.0, (5, 10))
    radius = np.hypot(f, torsion)
    u = (f**2 - torsion**2) / radius**2
    correction = 0.25 * (1.0 - u**2) * polynomial.polyval2d(2.0 / k - 1.0, u, table)
    inside = radius - (1.0 - correction)
    slack = fit_limit_surface.SLACK * (1.0 - u**2)
    assert np.all(inside >= slack - 1e-9)
    assert inside.max() == pytest.approx(error, rel=1e-3)
    assert error < 1e-3


@pytest.mark.long
def test_fitting_again_gives_the_surface_in_the_file() -> None:
    k, d = fit_limit_surface.sample_points()
    f, m = reference.point(k, d)
    table, error = fit_limit_surface.fit(
        1 / k, f, m / reference.torsion_limit(k), 1.0, fit_limit_surface.RADIUS_SHAPE
    )
    t, u = np.random.default_rng(2).uniform(-1, 1, (2, 500))
    assert error < 2.2e-5
    # the best fit is one in value, hardly in coefficients
    again, now = (polynomial.polyval2d(t, u, np.asarray(c)) for c in (table, fast.RADIUS_TABLE))
    assert 0.25 * (1 - u**2) * (again - now) == pytest.approx(np.zeros(500), abs=5e-6)
