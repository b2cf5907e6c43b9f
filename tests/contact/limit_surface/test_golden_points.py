"""Points of the limit surface known to ten digits, held against three computations that share no code."""

from collections.abc import Callable

import numpy as np
import pytest

from vegrip.contact.limit_surface import reference
from vegrip.contact.limit_surface.reference import AxisymmetricSurface

DISTANCES = (0, 0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 5, 10)
GOLDEN = {
    2: (
        (0, 0.5890486225),
        (0.1175152002, 0.5831802256),
        (0.2899223689, 0.5530959478),
        (0.5522330836, 0.4555922940),
        (0.7593204900, 0.3276007720),
        (0.8835729338, 0.2208932335),
        (0.9531183873, 0.1381376590),
        (0.9742785793, 0.1019093329),
        (0.9887523404, 0.0672111175),
        (0.9959826636, 0.0401154462),
        (0.9989989256, 0.0200143216),
    ),
    3: (
        (0, 0.6202450073),
        (0.1093866351, 0.6147803876),
        (0.2709512205, 0.5865637746),
        (0.5230228984, 0.4926471282),
        (0.7333914808, 0.3623142549),
        (0.8707465984, 0.2440918149),
        (0.9484457419, 0.1517223953),
        (0.9717643316, 0.1118024091),
        (0.9876659801, 0.0736839311),
        (0.9955968327, 0.0439642753),
        (0.9989030015, 0.0219316346),
    ),
    4: (
        (0, 0.6354098136),
        (0.1059068333, 0.6301184543),
        (0.2626505930, 0.6027363174),
        (0.5094317274, 0.5107077864),
        (0.7203649578, 0.3798799440),
        (0.8640993375, 0.2560114521),
        (0.9460703579, 0.1586148385),
        (0.9704899177, 0.1168120772),
        (0.9871162749, 0.0769578909),
        (0.9954017542, 0.0459099933),
        (0.9988545171, 0.0229006979),
    ),
}
DIGITS = 0.6e-10
ROWS = [(k, d, point) for k, points in GOLDEN.items() for d, point in zip(DISTANCES, points, strict=True)]

TORSION = {
    1: 0.5,
    2: 0.589048623,
    3: 0.620245007,
    4: 0.635409814,
    5: 0.644067431,
    6: 0.649519053,
    7: 0.653189662,
    8: 0.655785467,
    9: 0.657691796,
    10: 0.659134464,
    50: 0.666263664,
    np.inf: 0.666666667,
}

# creep at constant load: exponent, a/a0 and points at d/a = 0, .25, .5, 1, 2, torque over mu N a0
CONSTANT_LOAD = {
    0.2: (
        2.568902,
        1.067060,
        (
            (0, 0.650711),
            (0.277020, 0.613991),
            (0.532621, 0.512446),
            (0.875149, 0.251993),
            (0.972620, 0.115710),
        ),
    ),
    1.0: (
        3.695187,
        1.134233,
        (
            (0, 0.716520),
            (0.264609, 0.679190),
            (0.512692, 0.574279),
            (0.865746, 0.287037),
            (0.970803, 0.131094),
        ),
    ),
    np.inf: (
        3.856149,
        1.140175,
        (
            (0, 0.722585),
            (0.263528, 0.685209),
            (0.510896, 0.580041),
            (0.864843, 0.290381),
            (0.970631, 0.132552),
        ),
    ),
}


@pytest.mark.parametrize(("k", "d", "golden"), ROWS)
def test_quadrature_gives_the_golden_point(k: float, d: float, golden: tuple[float, float]) -> None:
    assert np.hstack(reference.point(k, d)) == pytest.approx(golden, abs=DIGITS)


@pytest.mark.parametrize(("k", "d", "golden"), [row for row in ROWS if row[1] > 0])
def test_area_integral_about_the_slip_centre_gives_the_golden_point(
    k: float, d: float, golden: tuple[float, float], area_integral: Callable[..., tuple[float, float]]
) -> None:
    assert area_integral(k, d) == pytest.approx(golden, abs=DIGITS)


@pytest.mark.parametrize(("d", "golden"), [row[1:] for row in ROWS if row[0] == 2 and row[1] <= 1])
def test_closed_form_of_the_hertz_profile_gives_the_golden_point(
    d: float, golden: tuple[float, float]
) -> None:
    f = 3 * np.pi / 8 * (d - d**3 / 4)
    m = 3 * np.pi / 16 * (1 - d**2 + 3 / 8 * d**4)
    assert (f, m) == pytest.approx(golden, abs=DIGITS)
    assert np.hstack(reference.point(2, d)) == pytest.approx((f, m), abs=1e-14)


@pytest.mark.parametrize(("k", "golden"), TORSION.items())
def test_torsion_limit_is_the_golden_one(k: float, golden: float) -> None:
    assert reference.torsion_limit(k) == pytest.approx(golden, abs=0.6e-9)


def test_torsion_limits_in_closed_form() -> None:
    known = {1: 1 / 2, 2: 3 * np.pi / 16, np.inf: 2 / 3}
    assert reference.torsion_limit(list(known)) == pytest.approx(list(known.values()), rel=1e-14)


@pytest.mark.parametrize("row", CONSTANT_LOAD.values())
def test_limit_surface_after_creep_at_constant_load(
    row: tuple[float, float, tuple[tuple[float, float], ...]],
) -> None:
    k, growth, golden = row
    f, m = reference.point(k, [0, 0.25, 0.5, 1, 2])
    assert np.stack([f, m * growth], axis=1) == pytest.approx(np.array(golden), abs=1.5e-6)


@pytest.mark.parametrize(("k", "golden"), [(2, 3 * np.pi / 8), (3, 1.095748865), (4, 1.060660172)])
def test_force_grows_from_pure_torsion_at_the_golden_slope(k: float, golden: float) -> None:
    f, _ = reference.point(k, 1e-6)
    assert f / 1e-6 == pytest.approx(golden, abs=1e-9)


@pytest.mark.parametrize("k", [2, 3, 4])
def test_general_profile_reduces_to_the_papers(k: int) -> None:
    surface = AxisymmetricSurface(lambda r: 7.0 * (1 - r**k) ** (1 / k))
    assert np.stack(surface.point(DISTANCES), axis=1) == pytest.approx(np.array(GOLDEN[k]), abs=DIGITS)
