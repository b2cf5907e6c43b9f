"""A finger whose states arrive broken is CORRUPT, one that is silent is STALE, and either is held."""

import pytest

from vegrip.messages import Condition, FingertipState, ForceCommand, ModelHealth

MS = 1_000_000


@pytest.mark.parametrize(("broken", "condition"), [(True, Condition.CORRUPT), (False, Condition.STALE)])
def test_broken_states_are_corrupt_and_silence_is_stale(broken, condition, make_node, state):
    node = make_node()
    node.configure()
    node.activate()
    last = 0
    for i in range(200):
        last = i * 2 * MS
        commands = [m for m in node.on_message(state(i), last) if isinstance(m, ForceCommand)]
    held = commands[-1].normal_force
    said = []
    for tick in range(1, 100):
        now = last + tick * 2 * MS
        if broken:
            node.on_broken(state(0).finger, now)
            node.on_broken("nobody", now)
        said += list(node.on_tick(now))
    conditions = [m.condition for m in said if isinstance(m, ModelHealth)]
    assert conditions
    assert set(conditions) == {condition}
    assert min(m.normal_force for m in said if isinstance(m, ForceCommand)) >= held


def test_broken_states_that_end_leave_silence(make_node, state):
    node = make_node()
    node.configure()
    node.activate()
    finger = node.fingers[state(0).finger]
    assert isinstance(state(0), FingertipState)
    for i in range(50):
        list(node.on_message(state(i), i * 2 * MS))
    for now in range(100 * MS, 300 * MS, 2 * MS):
        node.on_broken(finger.name, now)
        list(node.on_tick(now))
    assert finger.condition is Condition.CORRUPT
    for now in range(300 * MS, 400 * MS, 2 * MS):
        list(node.on_tick(now))
    assert finger.condition is Condition.STALE
