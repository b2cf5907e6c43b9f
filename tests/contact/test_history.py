"""Mixed histories: what is imposed and what follows can be exchanged; a tip does not pull."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from vegrip.contact.elastic import ElasticLaw, ExponentialStiffness, PowerStiffness
from vegrip.contact.hereditary import force, solve
from vegrip.contact.prony import Relaxation
from vegrip.errors import DomainError

G = Relaxation([0.25, 0.15], [5.0, 0.3])
HERTZ = PowerStiffness(4e4, 0.5)
LAWS = [HERTZ, ExponentialStiffness(300.0, 700.0)]


@st.composite
def pressings(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, indentations that never lose contact, and where the load shall be imposed."""
    n = draw(st.integers(3, 30))
    steps = draw(st.lists(st.one_of(st.just(0.0), st.floats(1e-4, 2)), min_size=n - 1, max_size=n - 1))
    deltas = draw(st.lists(st.floats(1.5e-3, 2e-3), min_size=n, max_size=n))
    imposed = draw(st.lists(st.booleans(), min_size=n, max_size=n))
    return np.cumsum([0.0, *steps]), np.array(deltas), np.array(imposed)


@pytest.mark.parametrize("law", LAWS, ids=repr)
@given(pressing=pressings())
def test_imposing_the_force_that_a_displacement_gave_gives_back_the_displacement(
    law: ElasticLaw, pressing: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> None:
    t, delta, load_imposed = pressing
    first = solve(t, law, G, indentation=delta)
    again = solve(
        t,
        law,
        G,
        indentation=np.where(load_imposed, np.nan, delta),
        normal_force=np.where(load_imposed, first.normal_force, np.nan),
    )
    assert again.indentation == pytest.approx(delta, rel=1e-9)
    assert again.normal_force == pytest.approx(first.normal_force, rel=1e-9)


@settings(max_examples=30)
@given(pressings())
def test_while_touching_the_history_is_the_hereditary_integral(
    pressing: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    t, delta, _ = pressing
    assert solve(t, HERTZ, G, indentation=delta).normal_force == pytest.approx(
        force(t, delta, HERTZ, G), rel=1e-12
    )


def test_hold_then_constant_load_is_continuous_and_creeps() -> None:
    t = np.linspace(0, 4, 401)
    held = t <= 2
    relaxed = 0.6 + 0.25 * np.exp(-10.0) + 0.15 * np.exp(-0.6)
    load = float(HERTZ.force(1e-3)) * relaxed
    mixed = solve(
        t, HERTZ, G, indentation=np.where(held, 1e-3, np.nan), normal_force=np.where(held, np.nan, load)
    )
    assert np.max(np.abs(np.diff(mixed.indentation[195:]))) < 1e-6
    assert np.all(np.diff(mixed.indentation[201:]) > 0)
    assert mixed.normal_force[200] == pytest.approx(load, rel=1e-12)


def released(t: np.ndarray, delta: np.ndarray) -> np.ndarray:
    """The free surface by a differential equation: elastic force that keeps the force at zero, per branch."""
    c, nu = np.array(G.amplitudes), np.array(G.rates)
    start = HERTZ.force(delta[0]) * np.ones(2)  # held for ever: the memories have caught up
    z = solve_ivp(lambda _, z: nu * (c @ z - z), (0, t[-1]), start, t_eval=t, rtol=1e-10, atol=1e-12).y
    return np.asarray(c @ z)


def test_a_released_surface_recovers_at_zero_force() -> None:
    hold = [0.0, 1e6]
    t = np.linspace(0, 3, 601)
    times = np.concatenate([hold, 1e6 + t])
    imposed = np.concatenate([[1e-3, 1e-3], np.full(601, -5e-3)])
    history = solve(times, HERTZ, G, indentation=imposed)
    assert np.all(history.normal_force[2:] == 0)
    assert not history.in_contact[2:].any()
    assert history.elastic_force[2:] == pytest.approx(released(t, imposed), rel=1e-4)


def test_contact_returns_at_the_dent_that_is_left_and_not_before() -> None:
    t = np.concatenate([[0.0, 50.0, 50.0], 50 + np.linspace(1e-3, 0.5, 500)])
    imposed = np.concatenate([[1e-3, 1e-3, 0.0], np.linspace(0, 1e-3, 500)])
    history = solve(t, HERTZ, G, indentation=imposed)
    back = np.flatnonzero(history.in_contact[2:])[0] + 2
    assert history.in_contact[back:].all()
    assert 0 < history.indentation[back - 1] - imposed[back - 1] < 1e-5  # still a gap, a small one
    assert imposed[back] > 1e-4
    assert history.normal_force[back] < 0.02 * history.normal_force[1]


@given(st.lists(st.floats(-1e-3, 2e-3), min_size=2, max_size=40))
def test_no_motion_makes_the_tip_pull(deltas: list[float]) -> None:
    history = solve(np.arange(len(deltas)) * 0.05, HERTZ, G, indentation=deltas)
    assert np.all(history.normal_force >= 0)
    assert np.all((history.normal_force > 0) == history.in_contact)
    assert np.all(history.indentation >= np.array(deltas) - 1e-15)


def test_before_the_first_touch_nothing_happens() -> None:
    history = solve([0.0, 1.0, 2.0], HERTZ, G, indentation=[-2e-3, -1e-3, 1e-3])
    assert history.normal_force[:2] == pytest.approx([0, 0])
    assert history.indentation[:2] == pytest.approx([0, 0])
    assert history.in_contact.tolist() == [False, False, True]


def test_letting_go_under_load_control_leaves_a_dent() -> None:
    history = solve([0.0, 100.0, 100.0, 101.0], HERTZ, G, normal_force=[2.0, 2.0, 0.0, 0.0])
    assert history.indentation[1] > history.indentation[2] > history.indentation[3] > 0
    assert history.in_contact.tolist() == [True, True, False, False]


def test_exactly_one_of_displacement_and_load_is_imposed() -> None:
    with pytest.raises(DomainError, match="exactly one"):
        solve([0.0, 1.0], HERTZ, G, indentation=[1e-3, np.nan])
    with pytest.raises(DomainError, match="exactly one"):
        solve([0.0, 1.0], HERTZ, G, indentation=1e-3, normal_force=1.0)


@pytest.mark.parametrize("load", [[1.0, -1e-3], [1.0, np.inf], [1.0, 2.0, 3.0]])
def test_loads_that_cannot_be_imposed_are_refused(load: list[float]) -> None:
    with pytest.raises(DomainError):
        solve([0.0, 1.0], HERTZ, G, normal_force=load)
