"""Internal forces of a grasp of any shape."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from tests.grip.stages import balance_forces
from vegrip.errors import ConfigError
from vegrip.grip.allocation.internal_forces import ContactPlace, InternalForces, contacts_of, grasp_map

force = st.floats(0.01, 20.0)
OPPOSED = {
    "thumb": ContactPlace((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "index": ContactPlace((0.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
    "middle": ContactPlace((0.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
}
PLATE = {
    "thumb": ContactPlace((0.0, 0.0, -0.01), (0.0, 0.0, 1.0)),
    "index": ContactPlace((-0.033, 0.0, 0.01), (0.0, 0.0, -1.0)),
    "middle": ContactPlace((-0.011, 0.004, 0.01), (0.0, 0.0, -1.0)),
    "ring": ContactPlace((0.011, 0.003, 0.01), (0.0, 0.0, -1.0)),
    "little": ContactPlace((0.033, -0.004, 0.01), (0.0, 0.0, -1.0)),
}
BALL = {
    name: ContactPlace(
        (-0.03 * math.cos(angle), -0.03 * math.sin(angle), 0.0), (math.cos(angle), math.sin(angle), 0.0)
    )
    for name, angle in zip("abc", (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0), strict=True)
}


def wrench(contacts: dict[str, ContactPlace], forces: Any) -> Any:
    return grasp_map(tuple(contacts.values())) @ [forces[name] for name in contacts]


@given(needs=st.lists(force, min_size=3, max_size=3))
def test_against_a_thumb_it_is_the_closed_form(needs: list[float]) -> None:
    asked = dict(zip(OPPOSED, needs, strict=True))
    assert InternalForces(OPPOSED).shared(asked) == pytest.approx(
        balance_forces(asked, "thumb"), rel=1e-5, abs=1e-6
    )


@given(needs=st.lists(force, min_size=5, max_size=5))
def test_forces_and_moments_balance_and_every_need_is_met(needs: list[float]) -> None:
    asked = dict(zip(PLATE, needs, strict=True))
    forces = InternalForces(PLATE).shared(asked)
    assert np.abs(wrench(PLATE, forces)).max() < 1e-5 * sum(forces.values())
    assert all(forces[name] >= asked[name] for name in asked)


@given(needs=st.lists(force, min_size=3, max_size=3))
def test_three_fingers_around_a_ball_press_alike(needs: list[float]) -> None:
    forces = InternalForces(BALL).shared(dict(zip(BALL, needs, strict=True)))
    assert list(forces.values()) == pytest.approx([max(needs)] * 3, rel=1e-5)


@pytest.mark.parametrize("seed", range(5))
def test_no_other_balance_adds_less(seed: int) -> None:
    """A general solver does not find a better one."""
    needs = np.random.default_rng(seed).uniform(0.3, 4.0, 5)
    grasp = grasp_map(tuple(PLATE.values()))
    found = minimize(
        lambda d: np.sum(d**2 / needs),
        np.full(5, 3.0),
        jac=lambda d: 2.0 * d / needs,
        method="SLSQP",
        bounds=[(0.0, None)] * 5,
        constraints={
            "type": "eq",
            "fun": lambda d: (grasp @ (needs + d))[[2, 3, 4]],
            "jac": lambda _: grasp[[2, 3, 4]],
        },
        options={"ftol": 1e-14, "maxiter": 300},
    )
    forces = InternalForces(PLATE).shared(dict(zip(PLATE, needs, strict=True)))
    assert list(forces.values()) == pytest.approx(list(needs + found.x), rel=1e-4, abs=1e-4)


def test_without_a_finger_needs_are_met_and_the_rest_does_what_it_can() -> None:
    asked = {"thumb": 2.0, "index": 1.0, "middle": 1.0}  # ring and little are not there: it would tilt
    forces = InternalForces(PLATE).shared(asked)
    assert forces.keys() == asked.keys()
    assert all(forces[name] >= asked[name] for name in asked)
    assert sum(forces.values()) < 10.0


def test_a_finger_without_a_contact_keeps_its_need() -> None:
    forces = InternalForces(OPPOSED).shared({"thumb": 3.0, "index": 1.0, "toe": 0.7})
    assert forces == pytest.approx({"thumb": 3.0, "index": 3.0, "toe": 0.7}, rel=1e-5)


def test_a_contact_that_is_not_told_is_at_the_origin_and_presses_along_z() -> None:
    assert ContactPlace() == ContactPlace((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def test_moments_are_about_the_mean_of_the_places_in_units_of_their_distance_from_it() -> None:
    places = np.array([contact.place for contact in PLATE.values()])
    arms = places - sum(places) / 5.0
    size = math.sqrt(sum(float(arm @ arm) for arm in arms) / 5.0)
    for column, arm, contact in zip(grasp_map(tuple(PLATE.values())).T, arms, PLATE.values(), strict=True):
        assert column == pytest.approx([*contact.normal, *np.cross(arm, contact.normal) / size], abs=1e-15)
    longer = [ContactPlace(one.place, tuple(7.0 * n for n in one.normal)) for one in PLATE.values()]
    assert grasp_map(tuple(longer)) == pytest.approx(grasp_map(tuple(PLATE.values())))


def test_a_balance_is_missed_by_a_hundred_millionth_of_what_is_added() -> None:
    """min d^2 + W^2 (2 - d)^2 with W = 1e4 is at d = 2 - 2 / (1 + W^2)."""
    forces = InternalForces(OPPOSED).shared({"thumb": 3.0, "index": 1.0})
    assert 3.0 - forces["index"] == pytest.approx(2.0 / (1.0 + 1e8), rel=1e-3)


def test_a_finger_that_needs_nothing_takes_part_with_a_thousandth_of_a_newton() -> None:
    forces = InternalForces(OPPOSED).shared({"thumb": 3.0, "index": 0.0, "middle": 1.0})
    assert forces["index"] / forces["middle"] == pytest.approx(1e-3, rel=1e-5)
    assert InternalForces(OPPOSED).shared({"thumb": 0.0}) == {"thumb": 0.0}  # alone it has nobody to help


@pytest.mark.parametrize(("need", "thumb"), [(0.999e9, 0.999e9), (1e9, 2.0), (math.inf, 2.0)])
def test_a_need_of_a_billion_newtons_is_not_balanced(need: float, thumb: float) -> None:
    forces = InternalForces(OPPOSED).shared({"thumb": 2.0, "index": need})
    assert forces == pytest.approx({"thumb": thumb, "index": need})


@pytest.mark.parametrize(("angle", "refused"), [(1.95e-3, False), (2.05e-3, True)])
def test_two_fingers_press_against_each_other_up_to_two_thousandths_off_a_line(
    angle: float, refused: bool
) -> None:
    """Equal forces leave 2 sin(angle / 2) of one, of which a thousandth of both is borne."""
    line = {"a": ContactPlace(), "b": ContactPlace(normal=(math.sin(angle), 0.0, -math.cos(angle)))}
    if refused:
        with pytest.raises(ConfigError, match="the fingers a, b cannot press against each other"):
            InternalForces(line)
    else:
        assert InternalForces(line).shared({"a": 1.0, "b": 1.0}) == pytest.approx({"a": 1.0, "b": 1.0})


@given(needs=st.dictionaries(st.sampled_from([*PLATE, "toe"]), st.floats() | st.just(0.0)))
def test_whatever_is_asked_nothing_raises_and_nothing_is_lowered(needs: dict[str, float]) -> None:
    forces = InternalForces(PLATE).shared(needs)
    assert forces.keys() == needs.keys()
    assert all(forces[name] >= need or math.isnan(need) for name, need in needs.items())


def test_when_the_solver_gives_up_the_needs_stand(monkeypatch: pytest.MonkeyPatch) -> None:
    grasp = InternalForces(PLATE)

    def give_up(*_: Any) -> None:
        raise RuntimeError("Maximum number of iterations reached.")

    monkeypatch.setattr("scipy.optimize.nnls", give_up)
    asked = dict.fromkeys(PLATE, 1.5)
    assert grasp.shared(asked) == asked


def test_fingers_on_one_side_are_refused() -> None:
    one_side = {name: PLATE[name] for name in ("index", "middle", "ring")}
    with pytest.raises(ConfigError, match="cannot press against each other"):
        InternalForces(one_side)


@pytest.mark.parametrize(
    ("entry", "complaint"),
    [
        ({"normal": [0.0, 0.0, 0.0]}, "must not be zero"),
        *[({"place": [1.0] * n}, "three finite numbers") for n in (0, 2, 4)],
        *[({"normal": [1.0] * n}, "three finite numbers") for n in (0, 2, 4)],
        ({"normal": [0.0, math.nan, 1.0]}, "finite"),
        ({"position": [0.0, 0.0, 0.0]}, "position"),
    ],
)
def test_a_wrong_contact_is_named(entry: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint):
        contacts_of({"index": entry}, "grasp")
