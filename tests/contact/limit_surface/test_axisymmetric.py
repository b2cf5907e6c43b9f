import numpy as np
import pytest

from vegrip.contact.limit_surface.reference import AxisymmetricSurface
from vegrip.errors import DomainError

PSI = np.linspace(0, np.pi / 2, 9)


def test_thin_ring_carries_torque_at_its_radius() -> None:
    ring = AxisymmetricSurface(lambda r: np.where((r > 0.999) & (r < 1), 1.0, 0.0), knots=(0, 0.999, 1))
    assert ring.point(0.0)[1] == pytest.approx(0.9995, abs=1e-6)


def test_matthews_profile_of_first_order_is_hertz() -> None:
    surface = AxisymmetricSurface(lambda r: (1 - r**2) ** (1 / 2))
    f, m = surface.point(1.0)
    assert (f, m) == (pytest.approx(9 * np.pi / 32), pytest.approx(9 * np.pi / 128))


def test_profile_in_pieces_is_the_sum_of_its_pieces() -> None:
    # a disc of half the radius on a disc: the friction of a sum of pressures is the sum of the frictions
    stepped = AxisymmetricSurface(lambda r: np.where(r < 0.5, 3.0, 1.0), knots=(0, 0.5, 1))
    disc = AxisymmetricSurface(np.ones_like)
    inner = 2.0 * 0.25 / (2.0 * 0.25 + 1.0)
    for d in (0.2, 0.5, 0.8, 2.0):
        assert stepped.support(d) == pytest.approx(
            inner * 0.5 * disc.support(d / 0.5) + (1 - inner) * disc.support(d), rel=1e-10
        )


def test_pressure_nearer_to_the_centre_holds_less() -> None:
    flat = AxisymmetricSurface(np.ones_like).radius(PSI)
    peaked = AxisymmetricSurface(lambda r: (1 - r) ** 2).radius(PSI)
    assert np.all(peaked[1:] < flat[1:])
    assert (peaked[0], flat[0]) == pytest.approx((1.0, 1.0))


@pytest.mark.parametrize(
    ("profile", "knots"),
    [
        (lambda r: 0.5 - r, (0, 1)),
        (np.zeros_like, (0, 1)),
        (np.ones_like, (0.1, 1)),
        (np.ones_like, (0, 0.7, 0.3, 1)),
    ],
)
def test_unusable_profile_is_refused(profile, knots) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(DomainError):
        AxisymmetricSurface(profile, knots)
