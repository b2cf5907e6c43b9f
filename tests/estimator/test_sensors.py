"""Gains of the sensors as they are stated: bounds, and what is different at a finger."""

import pytest

from vegrip import Sensors
from vegrip.config import build, constants, declaration
from vegrip.errors import ConfigError
from vegrip.estimator import EstimatorSettings
from vegrip.estimator.friction_prior import FrictionPrior
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


CONSTANTS = """
    horizon                  1      0      3600
    force_drift              0.1    -inf   inf
    force_drift_time         2      0.001  1e6
    displacement_drift       0.1    -inf   inf
    displacement_drift_time  0.5    0.001  1e6
    force_bias               2      -inf   inf
    offset                   0.002  -inf   inf
    longest_gap              0.25   0      3600
    late                     16     0      1000
    recovery                 15     1      1e6
    health_time              2      0.001  1e6
    friction_scatter         0.06   -inf   inf
    friction_drift           0.03   -inf   inf
    regrasp                  0.05   -inf   inf
"""
PRIOR = """
    coefficient              0      0      20
    coefficient_std          0      0      2
    load_exponent            0.15   -0.5   0.9
    load_exponent_std        0.12   0      1
    tangential_gain          0.92   0.5    2
    tangential_gain_std      0.1    0      1
"""


@pytest.mark.parametrize(("group", "table"), [(EstimatorSettings, CONSTANTS), (FrictionPrior, PRIOR)])
def test_what_only_python_sets_is_so_much_within_such_bounds(group, table):
    rows = {name: [*map(float, numbers)] for name, *numbers in map(str.split, table.strip().splitlines())}
    numbers = {name for name in constants(group) if isinstance(getattr(group(), name), int | float)}
    assert numbers <= rows.keys()
    for name, row in rows.items():
        declared = declaration(group, name)
        assert [getattr(group(), name), declared.low, declared.high] == row, name
