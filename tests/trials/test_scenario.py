"""A scenario is a function of its seed alone."""

from vegrip.trials.closed_loop import FRICTION_RANGE, Scenario
from vegrip.virtual.disturbance import Wetting


def test_the_same_seed_gives_the_same_object_and_fate() -> None:
    assert Scenario(3, 20.0).settings == Scenario(3, 20.0).settings
    assert Scenario(3, 20.0).events == Scenario(3, 20.0).events


def test_another_seed_gives_another_object_and_fate() -> None:
    assert Scenario(3, 20.0).settings != Scenario(4, 20.0).settings
    assert Scenario(3, 20.0).events != Scenario(4, 20.0).events


def test_the_faces_get_wet_once_in_the_second_half() -> None:
    for seed in range(20):
        wet = [event for event in Scenario(seed, 20.0).events if isinstance(event, Wetting)]
        assert len(wet) == 1
        assert 10.0 <= wet[0].start <= 14.0
        assert wet[0].start + wet[0].duration < 20.0
        assert FRICTION_RANGE[0] <= Scenario(seed, 20.0).settings.tip.friction <= FRICTION_RANGE[1]
