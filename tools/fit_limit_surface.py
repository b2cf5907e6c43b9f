"""Fit the tables of the fast limit surface and write them into ``fast.py``.

    python -m tools.fit_limit_surface

Both the surface and its support function are an ellipse times a correction (see ``fast.py``)::

    ratio = 1 - w P(x, u)      x = 1/k in [0, 1],   u in [-1, 1],   w = (1 - u^2)/4

w vanishes at pure force and pure torsion, where the ellipse is exact. P is a polynomial in 2x - 1 and u,
the one with the least greatest error among those that keep the fast surface *inside* the true one: a linear
programme, minimise e subject to slack <= w P - (1 - ratio) <= e at every sample.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from scipy.optimize import linprog

from vegrip.contact.limit_surface import fast, reference
from vegrip.types import Floats

FAST = Path(fast.__file__)
BEGIN, END = "# begin table\n# fmt: off", "# fmt: on\n# end table"

RADIUS_SHAPE, SUPPORT_SHAPE, TORSION_TERMS = (7, 16), (8, 18), 24
"""Terms in (x, u): more than the error bound needs, so that the slip direction is good as well."""

SLACK = 2e-6
"""How far the fit stays inside at the samples, so that it stays inside between them."""


def main() -> None:
    """Fit, replace what is between the markers of ``fast.py``, and say how good it is."""
    exponents, distances = sample_points()
    f, m = reference.point(exponents, distances)
    limit = reference.torsion_limit(exponents)
    radius, radius_error = fit(1.0 / exponents, f, m / limit, 1.0, RADIUS_SHAPE)
    # the support function of the slip (v, omega) = (d, 1) against that of the ellipse
    scale = distances * f + m
    support, support_error = fit(1.0 / exponents, distances / scale, limit / scale, -1.0, SUPPORT_SHAPE)
    tables = {"TORSION_TABLE": torsion_table(), "RADIUS_TABLE": radius, "SUPPORT_TABLE": support}
    write(tables)
    print(f"inside by at most: radius {radius_error:.1e}, support {support_error:.1e}")


def sample_points(x_count: int = 30, angle_count: int = 110) -> tuple[Floats, Floats]:
    """Exponents k and COR distances d, dense at d = 1 where the surface is least smooth."""
    x = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, x_count))
    angle = np.linspace(0.0, np.pi / 2.0, angle_count + 2)[1:-1]
    near_edge = 1.0 + 0.5 * np.linspace(-1.0, 1.0, angle_count // 2) ** 3
    d = np.sort(np.concatenate([np.tan(angle), near_edge]))
    exponents, distances = np.meshgrid(1.0 / np.maximum(x, 1e-12), d, indexing="ij")
    return exponents, distances


def fit(x: Floats, a: Floats, b: Floats, side: float, shape: tuple[int, int]) -> tuple[Floats, float]:
    """Fit P for (a, b) = radius/ellipse along (cos, sin), or ellipse/support; return powers and error.

    side is +1 if hypot(a, b) is fast over ellipse (radius), -1 if it is the inverse (support).
    """
    ratio = np.hypot(a, b) ** side
    u = (a**2 - b**2) / (a**2 + b**2)
    w = (1.0 - u**2) / 4.0
    basis = np.einsum(
        "ixy,jxy,xy->xyij",
        *(chebyshev.chebval(v, np.eye(n)) for v, n in zip((2 * x - 1, u), shape, strict=True)),
        w,
    ).reshape(x.size, -1)
    coefficients, error = least_greatest_above(basis, (1.0 - ratio).ravel(), SLACK * 4.0 * w.ravel())
    return as_powers(coefficients.reshape(shape)), error


def least_greatest_above(basis: Floats, goal: Floats, slack: Floats) -> tuple[Floats, float]:
    """Coefficients c with basis c >= goal + slack everywhere and the least greatest excess."""
    unit = 1e-5  # the excess in units the solver's tolerance of 1e-7 suits
    ones = np.ones((len(goal), 1))
    constraints = np.block([[-basis, 0.0 * ones], [basis, -unit * ones]])
    cost = np.append(np.zeros(basis.shape[1]), 1.0)
    bounds = [(None, None)] * basis.shape[1] + [(0.0, None)]
    limits = np.concatenate([-goal - slack, goal])
    solution = linprog(cost, A_ub=constraints, b_ub=limits, bounds=bounds, method="highs-ipm")
    if not solution.success or solution.x is None:
        raise RuntimeError(solution.message)
    return np.asarray(solution.x[:-1]), float(solution.x[-1] * unit)


def as_powers(coefficients: Floats) -> Floats:
    """Chebyshev coefficients in both variables to plain powers, for Horner's rule."""
    for axis in (0, 1):
        coefficients = np.apply_along_axis(_padded_powers, axis, coefficients)
    return coefficients


def _padded_powers(column: Floats) -> Floats:
    powers = chebyshev.cheb2poly(column)
    return np.asarray(np.pad(powers, (0, len(column) - len(powers))))


def torsion_table() -> Floats:
    """Powers of 2x - 1 for the torsion limit, good to 1e-11."""
    interpolant = chebyshev.Chebyshev.interpolate(
        lambda t: reference.torsion_limit(2.0 / np.maximum(1.0 + t, 1e-300)), TORSION_TERMS - 1
    )
    t = np.linspace(-1.0, 1.0, 1001)
    powers = _padded_powers(np.asarray(interpolant.coef, dtype=float))
    exact = reference.torsion_limit(2.0 / np.maximum(1.0 + t, 1e-300))
    worst = np.max(np.abs(polynomial.polyval(t, powers) - exact))
    if worst > 1e-11:
        raise RuntimeError(f"the torsion limit is only good to {worst:.1e}")
    return powers


def write(tables: dict[str, Floats]) -> None:
    """Put the tables between the markers of ``fast.py``."""
    text = FAST.read_text(encoding="utf-8")
    head, tail = text.split(BEGIN)[0], text.split(END)[1]
    lines = [line for name, table in tables.items() for line in literal(name, table)]
    FAST.write_text(head + "\n".join([BEGIN, *lines, END]) + tail, encoding="utf-8")


def literal(name: str, table: Floats) -> Iterator[str]:
    """One table as source text, one list of powers of u for each power of 2x - 1."""
    yield f"{name} = np.array(["
    if table.ndim == 1:
        yield from numbers(table, indent=4)
    else:
        for row in table:
            yield "    ["
            yield from numbers(row, indent=8)
            yield "    ],"
    yield "])"


def numbers(row: Floats, indent: int, per_line: int = 4) -> Iterator[str]:
    """A few numbers a line, to a precision of 1e-13."""
    for start in range(0, len(row), per_line):
        yield " " * indent + ", ".join(f"{value:+.13f}" for value in row[start : start + per_line]) + ","


if __name__ == "__main__":
    main()
