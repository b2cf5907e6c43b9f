"""Gains of the sensors as they are stated: bounds, and what is different at a finger."""

import pytest

from vegrip import Sensors
from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.grip.parameters import GraspParameters, estimator_factory


def test_without_a_word_tangential_forces_are_read_as_low_as_published_pads_read_them():
    sensors = GraspParameters().sensors
    assert (sensors.tangential_gain, sensors.tangential_gain_std) == (0.92, 0.1)


@pytest.mark.parametrize(
    ("key", "value", "bounds"),
    [
        ("tangential_gain", 0.49, "0.5 .. 2"),
        ("tangential_gain", 2.1, "0.5 .. 2"),
        ("tangential_gain", float("nan"), "0.5 .. 2"),
        ("tangential_gain_std", -0.01, "0 .. 1"),
        ("tangential_gain_std", 1.1, "0 .. 1"),
    ],
)
def test_a_gain_outside_its_bounds_is_refused_in_one_sentence(key, value, bounds):
    with pytest.raises(ConfigError) as refused:
        build(GraspParameters, {"sensors": {key: value}}, "hand.toml [parameters]")
    assert str(refused.value) == (
        f"hand.toml [parameters].sensors: {key!r} is {value:g}; it must lie in {bounds}"
    )


def test_what_a_finger_has_of_its_own_goes_before_what_all_have():
    table = {"tangential_gain": 0.9, "fingers": {"thumb": {"tangential_gain": 0.81}}}
    sensors = build(GraspParameters, {"sensors": table}, "x").sensors
    assert sensors.of("thumb") == Sensors(0.81, 0.1)
    assert sensors.of("index") == Sensors(0.9, 0.1)


@pytest.mark.parametrize(
    ("own", "said"),
    [
        (3.0, "sensors.fingers.thumb is 3.0; it must be a table"),
        ({"tangential_gain": 3.0}, "'tangential_gain' is 3; it must lie in 0.5 .. 2"),
        ({"gain": 1.0}, "unknown key 'gain'"),
    ],
)
def test_a_gain_of_one_finger_is_checked_likewise(own, said):
    with pytest.raises(ConfigError, match=said.replace(".", r"\.")):
        build(GraspParameters, {"sensors": {"fingers": {"thumb": own}}}, "x")


def test_a_finger_that_the_hand_has_not_is_refused():
    parameters = build(GraspParameters, {"sensors": {"fingers": {"toe": {}}}}, "x")
    with pytest.raises(ConfigError, match=r"'sensors\.fingers' has toe; the fingers are thumb, index"):
        estimator_factory(parameters, ("thumb", "index"), "x")
