"""The least normal force for a load, under every way the contact changes with that force."""

import inspect
import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from vegrip.contact.coupling import exponent_after_creep
from vegrip.contact.elastic import PowerStiffness
from vegrip.contact.limit_surface import fast, reference
from vegrip.contact.limit_surface.least_force import (
    LawOfForce,
    PowerLawContact,
    geometric_contact,
    least_normal_force,
)
from vegrip.errors import DomainError

contacts = st.builds(
    PowerLawContact,
    radius=st.floats(1e-3, 1e-2),
    exponent=st.floats(1.5, 10.0),
    at=st.floats(0.1, 10.0),
    radius_power=st.floats(-0.3, 0.6),
    exponent_power=st.floats(0.0, 0.1),
)
forces = st.floats(1e-3, 10.0)
torques = st.floats(1e-6, 1e-1)
frictions = st.floats(0.1, 2.0)


def as_functions(contact: PowerLawContact) -> LawOfForce:
    return LawOfForce(
        lambda N: contact.radius * (N / contact.at) ** contact.radius_power,
        lambda N: contact.exponent * (N / contact.at) ** contact.exponent_power,
    )


def gauge_at(N: float, force: float, torque: float, mu: float, contact: PowerLawContact) -> float:
    law = as_functions(contact)
    return fast.gauge(law.exponent(N), force / (mu * N), torque / (mu * N * law.radius(N)))


@settings(max_examples=200, deadline=None)
@given(contact=contacts, force=forces, torque=torques, mu=frictions)
def test_load_touches_the_surface_at_the_least_force(
    contact: PowerLawContact, force: float, torque: float, mu: float
) -> None:
    try:
        least = least_normal_force(force, torque, mu, contact)
    except DomainError:
        # only if the exponent falls below 1 before the force is that small
        assert contact.exponent_power > 0
        return
    assert gauge_at(least, force, torque, mu, contact) == pytest.approx(1.0, rel=1e-8)
    assert gauge_at(1.01 * least, force, torque, mu, contact) < 1


@settings(max_examples=50, deadline=None)
@given(contact=contacts, force=forces, torque=torques, mu=frictions)
def test_compiled_solution_is_that_of_the_functions(
    contact: PowerLawContact, force: float, torque: float, mu: float
) -> None:
    try:
        least = least_normal_force(force, torque, mu, contact)
        again = least_normal_force(force, torque, mu, as_functions(contact))
    except DomainError:
        assert contact.exponent_power > 0
        return
    assert again == pytest.approx(least, rel=1e-9)


@settings(max_examples=60, deadline=None)
@given(contact=contacts, force=forces, torque=torques, mu=frictions, more=st.floats(1.0, 3.0))
def test_more_load_needs_more_force_and_more_friction_less(
    contact: PowerLawContact, force: float, torque: float, mu: float, more: float
) -> None:
    try:
        needed = least_normal_force(force, torque, mu, contact)
        loads = [(more * force, torque), (force, more * torque)]
        heavier = [least_normal_force(*load, mu, contact) for load in loads]
        easier = least_normal_force(force, torque, mu * more, contact)
    except DomainError:
        assert contact.exponent_power > 0
        return
    assert min(heavier) >= needed * (1 - 3e-5)
    assert easier <= needed * (1 + 3e-5)


@pytest.mark.parametrize("scale", [1e-12, 1e-6, 1.0, 1e6])
def test_answer_scales_with_the_units(scale: float) -> None:
    contact = PowerLawContact(0.004 * scale, 2.0, at=scale, radius_power=1 / 3)
    least = least_normal_force(scale, 0.002 * scale**2, 0.5, contact)
    assert least / scale == pytest.approx(
        least_normal_force(1.0, 0.002, 0.5, PowerLawContact(0.004, 2.0, radius_power=1 / 3)), rel=1e-9
    )


def test_constant_area_needs_the_gauge_over_the_friction() -> None:
    contact = PowerLawContact(radius=0.005, exponent=3.0)
    f, m = reference.point(3.0, 0.7)  # a load on the surface at N = 2, mu = 0.5
    least = least_normal_force(2 * 0.5 * f, 2 * 0.5 * 0.005 * m, 0.5, contact)
    assert least == pytest.approx(2.0, rel=3e-5)
    assert least >= 2.0


def test_pure_force_and_pure_torque_in_closed_form() -> None:
    contact = PowerLawContact(radius=0.005, exponent=2.0, at=2.0, radius_power=0.25)
    assert least_normal_force(1.5, 0.0, 0.6, contact) == pytest.approx(2.5, rel=1e-10)
    # mu M a1 (N/N1)^0.25 N = torque
    torque = 0.6 * 3 * math.pi / 16 * 0.005 * (3.0 / 2.0) ** 0.25 * 3.0
    assert least_normal_force(0.0, torque, 0.6, contact) == pytest.approx(3.0, rel=1e-9)
    assert least_normal_force(0.0, 0.0, 0.6, contact) == 0.0


def test_signs_of_the_load_do_not_matter() -> None:
    contact = PowerLawContact(radius=0.005, exponent=2.0, radius_power=0.3)
    values = {least_normal_force(s * 1.0, t * 0.01, 0.5, contact) for s in (1, -1) for t in (1, -1)}
    assert len(values) == 1


def test_margin_leaves_that_part_of_the_surface_unused() -> None:
    contact = PowerLawContact(radius=0.005, exponent=2.0, radius_power=0.3)
    least = least_normal_force(1.0, 0.004, 0.5, contact, margin=0.25)
    assert gauge_at(least, 1.0, 0.004, 0.5, contact) == pytest.approx(0.75, rel=1e-8)


def test_geometric_contact_follows_stiffness_and_geometry() -> None:
    stiffness = PowerStiffness(m=6e4, b=0.5)
    contact = geometric_contact(0.008, stiffness)
    assert contact.exponent == 2.0
    for N in (0.01, 0.5, contact.greatest):
        delta = float(stiffness.indentation(N))
        assert as_functions(contact).radius(N) == pytest.approx(math.sqrt(2 * 0.008 * delta), rel=1e-12)
    assert float(stiffness.indentation(contact.greatest)) == pytest.approx(0.008, rel=1e-12)


def test_crept_contact_has_grown_and_flattened() -> None:
    fresh = geometric_contact(0.008, PowerStiffness(m=6e4, b=0.5), k=2.0)
    crept = geometric_contact(0.008, PowerStiffness(m=6e4, b=0.5), k=2.0, creep=1.3)
    assert crept.radius == pytest.approx(fresh.radius * math.sqrt(1.3))
    assert crept.exponent == pytest.approx(float(exponent_after_creep(1.3).k))
    assert least_normal_force(0.5, 0.004, 0.5, crept) < least_normal_force(0.5, 0.004, 0.5, fresh)


def test_any_law_is_solved_as_by_an_independent_root_search() -> None:
    law = LawOfForce(lambda N: 0.004 * math.log1p(3 * N), lambda N: 2.0 + math.tanh(N))

    def excess(N: float) -> float:
        psi = math.atan2(0.003 / law.radius(N), 1.0)
        return math.hypot(1.0, 0.003 / law.radius(N)) / (0.5 * N) - float(
            reference.radius(law.exponent(N), psi)
        )

    assert least_normal_force(1.0, 0.003, 0.5, law) == pytest.approx(brentq(excess, 1, 20), rel=3e-5)


@pytest.mark.parametrize(
    "contact",
    [PowerLawContact(0.005, 2.0, greatest=3.0), LawOfForce(lambda _: 0.005, lambda _: 2.0, greatest=3.0)],
)
def test_load_beyond_the_contact_law_is_refused(contact: PowerLawContact | LawOfForce) -> None:
    assert least_normal_force(1.2, 0.0, 0.5, contact) == pytest.approx(2.4)
    with pytest.raises(DomainError, match="3 N"):
        least_normal_force(1.6, 0.0, 0.5, contact)


def test_a_contact_law_is_good_up_to_its_greatest_force_and_that_force_too() -> None:
    least = least_normal_force(1.2, 0.002, 0.5, PowerLawContact(0.005, 2.0))
    assert least_normal_force(1.2, 0.002, 0.5, PowerLawContact(0.005, 2.0, greatest=least)) == least
    with pytest.raises(DomainError, match="the contact law holds up to"):
        least_normal_force(1.2, 0.002, 0.5, PowerLawContact(0.005, 2.0, greatest=math.nextafter(least, 0.0)))


@pytest.mark.parametrize(
    ("radius", "torque", "said"),
    [
        (lambda N: 1.0 / N**2, 0.1, "no normal force is too small"),
        (lambda N: 1.0 / N, 9.0, "2.58225e\\+120 N"),
    ],
)
def test_a_contact_that_shrinks_as_fast_as_the_force_grows_has_no_least_force(radius, torque, said) -> None:
    with pytest.raises(DomainError, match=said):
        least_normal_force(0.0, torque, 0.5, LawOfForce(radius, lambda _: 2.0))


def test_exponent_that_falls_below_one_is_refused() -> None:
    contact = PowerLawContact(0.005, 1.2, at=1.0, exponent_power=1.0)
    with pytest.raises(DomainError, match="exponent"):
        least_normal_force(0.1, 1e-4, 0.5, contact)
    with pytest.raises(DomainError, match="exponent"):
        least_normal_force(0.1, 1e-4, 0.5, as_functions(contact))


@pytest.mark.parametrize(
    ("force", "torque", "mu", "margin"),
    [
        (math.nan, 0.0, 0.5, 0.0),
        (1.0, math.inf, 0.5, 0.0),
        (1.0, 0.0, 0.0, 0.0),
        (1.0, 0.0, math.nan, 0.0),
        (1.0, 0.0, 0.5, 1.0),
        (1.0, 0.0, 0.5, -0.1),
    ],
)
def test_question_without_an_answer_is_refused(force: float, torque: float, mu: float, margin: float) -> None:
    with pytest.raises(DomainError):
        least_normal_force(force, torque, mu, PowerLawContact(0.005, 2.0), margin)


@pytest.mark.parametrize(
    "wrong",
    [{"radius": 0.0}, {"exponent": 0.9}, {"at": -1.0}, {"radius_power": -1.0}, {"greatest": math.nan}],
)
def test_impossible_contact_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(DomainError):
        PowerLawContact(**({"radius": 0.005, "exponent": 2.0} | wrong))


def test_compiled_search_answers_nan_where_the_checked_one_raises() -> None:
    assert math.isnan(fast.least_normal_force(1.0, 0.0, 0.0, 0.005, 2.0))
    assert math.isnan(fast.least_normal_force(math.nan, 0.0, 0.5, 0.005, 2.0))
    assert math.isnan(fast.least_normal_force(1.0, 0.1, 0.5, 0.005, 0.5))
    assert math.isnan(fast.least_normal_force(1.0, 0.1, 0.5, 0.005, 2.0, 1.0, -1.0))
    assert math.isnan(fast.least_normal_force(1.0, 0.1, 0.5, 0.0, 2.0, 1.0, 0.3))
    assert math.isnan(fast.least_normal_force(1.0, 0.1, 0.5, 0.005, 2.0, 0.0, 0.3))
    assert 2.0 < fast.least_normal_force(1.0, 0.1, 0.5, 0.005, 1.0, 1.0, 0.3) < math.inf


@pytest.mark.parametrize("mu", [0.5, math.inf])
def test_no_load_needs_no_force_and_a_load_without_end_none_that_there_is(mu: float) -> None:
    assert fast.least_normal_force(0.0, 0.0, mu, 0.005, 2.0) == 0.0
    assert fast.least_normal_force(0.0, 0.0, mu, 0.005, 2.0, 1.0, 0.3, 0.1) == 0.0
    if mu < math.inf:
        for load in ((math.inf, 0.0), (0.0, -math.inf), (-math.inf, math.inf)):
            assert fast.least_normal_force(*load, mu, 0.005, 2.0) == math.inf
            assert fast.least_normal_force(*load, mu, 0.005, 2.0, 1.0, 0.3, 0.1) == math.inf


@pytest.mark.parametrize("at", [0.3, 5.0])
def test_the_search_begins_at_the_answer_for_pure_loads_and_ends_in_four_steps(at: float) -> None:
    """As from a root search by the same gauge, where radius and exponent change with the force."""
    names: dict[str, Any] = {}
    exec(inspect.getsource(fast).replace("@njit", ""), names)  # noqa: S102
    search, law = names["least_normal_force"], (0.005, 2.0, at, 0.3)
    names["NEWTON_STEPS"] = 1
    assert search(0.7, 0.0, 0.5, *law, 0.0) == pytest.approx(1.4, rel=1e-12)
    torque = 0.5 * 2.0 * 0.005 * (2.0 / at) ** 0.3 * fast.torsion_limit(2.0)
    assert search(0.0, torque, 0.5, *law, 0.0) == pytest.approx(2.0, rel=1e-12)
    names["NEWTON_STEPS"] = 4
    for powers in ((0.3, 0.05), (0.0, 0.05), (1.0, 0.0)):
        contact = PowerLawContact(0.005, 2.0, at, *powers)
        for load in ((0.7, 0.002), (0.1, 0.004), (3.0, 0.02)):
            found = search(*load, 0.5, 0.005, 2.0, at, *powers)
            assert gauge_at(found, *load, 0.5, contact) == pytest.approx(1.0, rel=1e-7)


def test_a_contact_of_which_no_power_is_given_stays_as_it_is() -> None:
    search, gauge = fast.least_normal_force.py_func, fast.gauge(2.0, 1.0, 0.004 / 0.005)
    assert search(1.0, 0.004, 0.5, 0.005, 2.0) == pytest.approx(gauge / 0.5, rel=1e-12)
    given = search(1.0, 0.004, 0.5, 0.005, 2.0, 1.0, 0.3, 0.0)
    assert search(1.0, 0.004, 0.5, 0.005, 2.0, radius_power=0.3) == given
    assert given != pytest.approx(gauge / 0.5, rel=1e-3)


@pytest.mark.parametrize("is_of_any_law", [False, True])
@pytest.mark.parametrize("load", [(1.0, 1.0), (0.5, 0.5), (1e-3, 1e-3)])
def test_a_force_and_a_torque_of_equal_numbers_are_a_load_as_any(
    load: tuple[float, float], is_of_any_law: bool
) -> None:
    contact = PowerLawContact(radius=5e-3, exponent=3.0, at=1.0, radius_power=0.3, exponent_power=0.0)
    least = least_normal_force(*load, 0.8, as_functions(contact) if is_of_any_law else contact)
    assert least > load[0] / 0.8
    assert gauge_at(least, *load, 0.8, contact) == pytest.approx(1.0, rel=1e-4)
