"""Balance of the internal forces about the thumb."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.grip.stages import balance_forces

force = st.just(0.0) | st.floats(1e-12, 100.0)
OTHERS = ("index", "middle", "ring", "little")


@given(thumb=force, others=st.lists(force, min_size=1, max_size=4))
def test_the_thumb_carries_the_sum_and_every_need_is_met(thumb: float, others: list[float]) -> None:
    needs = {"thumb": thumb, **dict(zip(OTHERS, others, strict=False))}
    forces = balance_forces(needs, "thumb")
    assert forces["thumb"] == pytest.approx(sum(forces[name] for name in needs if name != "thumb"), rel=1e-12)
    assert all(forces[name] >= needs[name] * (1.0 - 1e-12) for name in needs)


@given(thumb=force, others=st.lists(st.floats(1e-3, 100.0), min_size=4, max_size=4))
def test_no_smaller_grasp_meets_the_needs(thumb: float, others: list[float]) -> None:
    """The thumb needs at least its own need and at least the sum: the greater of both is the optimum."""
    forces = balance_forces({"thumb": thumb, **dict(zip(OTHERS, others, strict=True))}, "thumb")
    assert forces["thumb"] == pytest.approx(max(thumb, sum(others)))


def test_when_the_thumb_needs_more_the_fingers_share_in_proportion() -> None:
    forces = balance_forces({"thumb": 6.0, "index": 2.0, "middle": 1.0}, "thumb")
    assert forces == pytest.approx({"thumb": 6.0, "index": 4.0, "middle": 2.0})


def test_without_a_thumb_nothing_changes() -> None:
    needs = {"left": 1.0, "right": 2.0}
    assert balance_forces(needs, "thumb") == needs
    assert balance_forces({"thumb": 2.0}, "thumb") == {"thumb": 2.0}
    silent = balance_forces({"thumb": math.nan, **needs}, "thumb")
    assert {name: silent[name] for name in needs} == needs


def test_fingers_that_need_nothing_share_equally() -> None:
    assert balance_forces({"thumb": 3.0, "index": 0.0, "middle": 0.0}, "thumb") == pytest.approx(
        {"thumb": 3.0, "index": 1.5, "middle": 1.5}
    )
