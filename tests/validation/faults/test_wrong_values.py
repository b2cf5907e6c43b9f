"""One bad sample must not drop the object: the worst kinds of every channel; the whole table is a command."""

import pytest

from validation.faults.wrong_values import FAULT_BEGIN_S, Fault, judge

KNOWN = [
    pytest.param("torque_z", 1.9, 0.005, marks=pytest.mark.long),
    pytest.param("tangential_force_x", 5.0, 0.005, marks=pytest.mark.long),
    ("tangential_force_x", 0.0, 1.0),
    pytest.param("normal_force", -4.0, 1.0, marks=pytest.mark.long),
    ("slip", 1.0, 0.05),
]
"""What an attack found, and one of each other kind."""


@pytest.mark.parametrize(("channel", "value", "duration"), KNOWN)
def test_a_wrong_value_neither_lets_the_grip_down_nor_teaches_a_friction(channel, value, duration):
    verdict = judge(Fault(channel, value, FAULT_BEGIN_S, duration, -1))
    assert verdict.fallen <= 1.0
    assert verdict.maximum <= 2.5  # the largest command lasts for 0.5 s; see docs/faults.md for which do not
    assert verdict.off <= 1.0
    assert verdict.shrunk <= 1.0


BELIEVED = pytest.mark.xfail(
    strict=True, reason="told by all fingers at once where the load makes a slide likely, it is believed"
)


@pytest.mark.parametrize(
    ("channel", "value", "duration"),
    [
        pytest.param("slip", 1.0, 0.05, marks=[pytest.mark.long, BELIEVED]),
        pytest.param("slip", 1.0, 1.0, marks=pytest.mark.long),
        ("slip_speed", 0.5, 1.0),
    ],
)
def test_a_slip_channel_that_lies_neither_teaches_nor_keeps_the_grip_up_with_learning(
    channel, value, duration
):
    verdict = judge(Fault(channel, value, FAULT_BEGIN_S, duration, -1), learning=True)
    assert verdict.worst <= 1.0


@pytest.mark.parametrize(
    ("channel", "value", "duration"),
    [("torque_z", -1.9, 0.05), pytest.param("tangential_force_x", -5.0, 0.05, marks=pytest.mark.long)],
)
def test_a_wrong_load_teaches_nothing_that_a_node_with_sound_input_does_not_learn(channel, value, duration):
    verdict = judge(Fault(channel, value, FAULT_BEGIN_S, duration, -1), learning=True)
    assert verdict.fallen == 0.0
    assert verdict.off < 0.1
    assert verdict.shrunk < 0.1
    assert verdict.risen < 0.1


@pytest.mark.parametrize("value", [pytest.param(0.0, marks=pytest.mark.long), -1.9])
def test_a_torque_that_is_wrong_for_a_second_neither_teaches_nor_leaves_a_finger_fail_safe(value):
    """Zero would let the grip down to a slip; after the large one the tips recover from 15 N."""
    assert judge(Fault("torque_z", value, FAULT_BEGIN_S, 1.0, -1), learning=True).worst <= 1.0
