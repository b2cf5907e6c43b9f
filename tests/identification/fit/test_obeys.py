"""What no contact does is said of a model, and of no effect of the catalogue."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.effects import BUILT_IN, effect
from vegrip.effects.file import effect_of
from vegrip.identification.draft.grammar import LAW_PLACES, LAW_SHAPES, LAW_VARIABLES, Law
from vegrip.identification.draft.text import law_text
from vegrip.identification.fit import obeys
from vegrip.identification.fit.obeys import broken_by, broken_over
from vegrip.model import BASE, paper_model

PLAIN = paper_model(8e-3)


@pytest.mark.parametrize("name", [name for name in BUILT_IN if name not in BASE])
def test_no_effect_of_the_catalogue_breaks_a_law(name: str) -> None:
    assert list(broken_over(PLAIN.with_effect(effect(name)), 1.2e-3, (3e-4, 1e-2), 20.0)) == []


def with_law(place: str, variable: str, amount: float) -> tuple[str, ...]:
    law = Law(LAW_PLACES[place], LAW_VARIABLES[variable], LAW_SHAPES["linear"], 1.0)
    made = effect_of(law_text(law, "one", {}), "the draft")
    model = PLAIN.with_effect(made).with_value("c_one", amount)
    return tuple(broken_over(model, depth=1e-3, speeds=(1e-3, 1e-2), length=20.0))


@pytest.mark.parametrize(
    ("place", "variable", "amount", "broken"),
    [
        ("elastic", "depth", 0.5, ""),
        ("elastic", "depth", -0.7, "pressing deeper takes less force"),
        ("force", "contact_time", 0.3, "grows under a constant indentation"),
        ("force", "speed", -0.1, "gives back more work"),
        ("force", "time", 5.0, "grows without bound"),
        ("sense", "time", 1.0, ""),
    ],
)
def test_a_law_that_no_contact_obeys_is_named(place: str, variable: str, amount: float, broken: str) -> None:
    told = with_law(place, variable, amount)
    assert (told == ()) if not broken else any(broken in sentence for sentence in told), told


Force = Callable[[np.ndarray, np.ndarray], np.ndarray]


def spring(_: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.maximum(x, 0.0)


def shaken(share: float, begin: float, end: float) -> Force:
    """Return a spring that rests on the way in and is weaker by ``share`` for a while."""
    return lambda t, x: np.where(
        t < 0.75, np.minimum(spring(t, x), 0.5) - share * ((t > begin) & (t < end)), spring(t, x)
    )


def stronger(share: float, begin: float, end: float) -> Force:
    return lambda t, x: spring(t, x) * (1.0 + share * ((t > begin) & (t < end)))


BROKEN: dict[str, Callable[[float], Force]] = {
    "pushes before it touches": lambda s: lambda t, x: np.where(x < -0.03, s, spring(t, x)),
    "grows under a constant": lambda s: (
        lambda t, x: spring(t, x) + s * (x >= 1.0) * np.clip((t - 1.2) / 5.0, 0.0, 1.0)
    ),
    "deeper takes less": lambda s: shaken(s, 0.74, 0.75),
    "gives back more work": lambda s: stronger(2.0 * s, 6.2, 7.2),
    "back more work than was put in": lambda s: stronger(2.0 * s, 8.6, 9.6),
}


def told_of(force: Force) -> list[str]:
    """Return what is said of a force, by depth and time over those of a press, which is held from 1.2 to 6.2.

    It is pressed to 2 m in half a second.
    """

    def simulate(t: np.ndarray, x: np.ndarray) -> SimpleNamespace:
        return SimpleNamespace(normal_force=7.0 * force(t / 0.5, x / 2.0), indentation=x)

    return list(broken_over(SimpleNamespace(simulate=simulate), 2.0, (4.0,), 2.5))  # type: ignore[arg-type]


@pytest.mark.parametrize("broken", BROKEN)
def test_a_law_is_broken_by_two_thousandths_of_the_greatest_force_or_of_the_work(broken: str) -> None:
    assert told_of(BROKEN[broken](0.0019)) == []
    (told,) = told_of(BROKEN[broken](0.0022))
    assert broken in told
    assert told.startswith("at 4e+03 mm/s ")


def test_a_surface_may_pull_before_it_pushes() -> None:
    assert (
        told_of(lambda t, x: np.where((t < 1.0) & (x < 1.0), -0.01 * (t > 0.5), spring(t, x) * (t < 6.2)))
        == []
    )


@pytest.mark.parametrize(
    ("grown", "told"), [(2.99, []), (3.01, ["held for 25 s the force grows without bound"])]
)
def test_a_held_force_grows_without_bound_from_three_times_what_it_was(grown: float, told: list[str]) -> None:
    long = told_of(lambda t, x: np.where(t[-1] > 20.0, 1.0 + (grown - 1.0) * t / t[-1], spring(t, x)))
    assert long == told


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_a_force_that_is_not_finite_or_none_is_told_once_a_speed(value: float) -> None:
    assert told_of(lambda t, _: np.full(t.size, 1.0 if t[-1] > 20.0 else value)) == [
        "the force is not finite"
    ]


def test_presses_are_held_for_ten_times_their_rise_and_no_longer_than_was_recorded() -> None:
    asked: list[list[float]] = []

    def simulate(t: np.ndarray, x: np.ndarray) -> SimpleNamespace:
        asked.append([float(t[-1]), *x[:: (t.size - 1) // 8][:9], t.size])
        return SimpleNamespace(normal_force=spring(t, x), indentation=x)

    list(broken_over(SimpleNamespace(simulate=simulate), 2.0, (1.0, 0.1), 30.0))  # type: ignore[arg-type]
    corners = [-0.4, -0.04, 2.0, 2.0, -0.04, -0.04, 2.0, 2.0, -0.04]
    expected = [[29.2, *corners, 4000], [122.0, *corners, 4000], [300.0, *[2.0] * 9, 2000]]
    assert np.array(asked) == pytest.approx(np.array(expected), abs=0.03)


def test_a_model_is_tried_at_the_quickest_and_a_slow_speed_of_what_touches(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    asked: list[tuple[object, ...]] = []
    monkeypatch.setattr(obeys, "broken_over", lambda *given: asked.append(given) or [])
    rates = np.repeat([50.0, 0.15, 0.05, 0.2, 2.0], 200)  # [m/s]; in the air, at rest, slowly and quickly
    t = 5.0 + 0.01 * np.arange(1000)
    motion = SimpleNamespace(displacement=np.cumsum(0.01 * rates))
    measured, touching = (
        SimpleNamespace(motion=motion, recording=SimpleNamespace(t=t, is_step=False)),
        np.arange(1000) >= 402,
    )
    for stiffness in (0.0 * rates, 0.5 * touching):
        list(broken_by(PLAIN, SimpleNamespace(measured=measured, stiffness=stiffness)))  # type: ignore[arg-type]
    ((_, depth, speeds, length),) = asked
    assert depth == motion.displacement[-1]
    assert speeds == pytest.approx((0.2, 2.0))
    assert length == pytest.approx(9.99)
