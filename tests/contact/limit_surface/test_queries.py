import numpy as np
import pytest

from vegrip.contact.limit_surface import queries, reference
from vegrip.errors import DomainError


def test_queries_broadcast() -> None:
    assert queries.gauge([2, 3], [[0.1], [0.2], [0.3]], 0.1).shape == (3, 2)
    assert queries.radius([2, 3, 4], 0.3).shape == (3,)
    assert queries.gauge(2, 0.1, 0.1).shape == ()


def test_point_of_a_slip_centre_is_on_the_surface_and_gives_it_back() -> None:
    d = np.array([0.0, 0.3, 1.0, 4.0, np.inf])
    f, m = queries.point(2.5, d)
    assert queries.gauge(2.5, f, m) == pytest.approx(np.ones(5), abs=3e-5)
    assert np.arctan(queries.cor_distance(2.5, f, m)) == pytest.approx(np.arctan(d), abs=1e-3)


def test_inside_and_outside() -> None:
    f, m = queries.point(2.0, [0.2, 1.0, 3.0])
    assert queries.is_inside(2.0, 0.999 * f, 0.999 * m).all()
    assert not queries.is_inside(2.0, 1.001 * f, 1.001 * m).any()


def test_slip_follows_the_signs_of_the_load() -> None:
    v, omega = queries.slip_twist(2.0, [0.4, -0.4], [-0.3, 0.3])
    assert v[0] == -v[1] > 0
    assert omega[0] == -omega[1] < 0
    assert np.hypot(v, omega) == pytest.approx([1, 1])


def test_support_of_a_slip_is_its_dissipation() -> None:
    assert queries.support(3.0, 0.7, 1.0) == pytest.approx(float(reference.support(3.0, 0.7)), rel=5e-5)
    assert queries.support(3.0, 1.4, -2.0) == pytest.approx(2 * float(queries.support(3.0, 0.7, 1.0)))


@pytest.mark.parametrize(
    "question",
    [
        lambda: queries.gauge(0.9, 0.1, 0.1),
        lambda: queries.gauge(2.0, np.nan, 0.1),
        lambda: queries.gauge(2.0, 0.1, np.inf),
        lambda: queries.radius(2.0, 1.6),
        lambda: queries.point(2.0, -1.0),
        lambda: queries.support(np.nan, 1.0, 1.0),
        lambda: queries.slip_twist(2.0, 0.0, 0.0),
        lambda: queries.cor_distance(2.0, [0.1, 0.0], [0.1, 0.0]),
    ],
)
def test_outside_the_domain_is_refused(question) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(DomainError):
        question()
