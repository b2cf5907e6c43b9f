"""A finger whose states arrive broken is CORRUPT, one that is silent is STALE, and either is held."""

import dataclasses
import math

import numpy as np
import pytest

from vegrip.grip.controller import GripController
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Condition, FingertipState, ForceCommand, ModelHealth
from vegrip.model import paper_model

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


NO_NUMBERS = (None, "3", complex(1.0, 0.0), np.array([3.0]), [3.0])
BROKEN = [
    *[{name: value} for name in ("normal_force", "slip", "displacement") for value in (*NO_NUMBERS, 10**400)],
    *[{name: value} for name in ("stamp", "seq") for value in (*NO_NUMBERS, math.nan, math.inf)],
]


@pytest.fixture(scope="module")
def hand():
    return GripController(("thumb", "index"), model=paper_model(8e-3))


@pytest.mark.parametrize("change", BROKEN, ids=str)
def test_a_state_without_numbers_is_broken_input_of_its_finger_alone(change, hand, state):
    hand.reset(ControlSettings())
    hand.rejected.clear()
    for i in range(100):
        now = i * 2 * MS
        thumb, index = (dataclasses.replace(state(i), finger=name) for name in hand.names)
        if i >= 50:
            thumb = dataclasses.replace(thumb, **change)
        commands = hand.step([thumb, index], now)
        assert "index" in {command.finger for command in commands}
    assert hand.fingers["thumb"].condition is Condition.CORRUPT
    assert hand.fingers["index"].condition is Condition.OK
    assert hand.rejected == {"broken state": 50}


@pytest.mark.parametrize("policy", ["margin", "own"])
def test_a_broken_state_is_left_alone_one_by_one_too(policy, hand, state):
    contacts = {"thumb": {}, "index": {"normal": [0.0, 0.0, -1.0]}} if policy == "own" else {}
    hand.reset(ControlSettings(contacts=contacts))
    hand.rejected.clear()
    assert hand.answer(dataclasses.replace(state(0), finger="thumb"), 0) != 0
    assert hand.answer(dataclasses.replace(state(1), finger="thumb", slip=None), 2 * MS) == 0
    assert hand.rejected == {"broken state": 1}


@pytest.mark.parametrize("kind", [float, np.int64, np.float64])
def test_a_time_of_another_kind_of_number_is_one(kind, hand, state):
    answers = []
    for of in (int, kind):
        hand.reset(ControlSettings())
        states = [dataclasses.replace(state(i), finger="thumb") for i in range(50)]
        answers.append([
            hand.step([dataclasses.replace(one, stamp=of(one.stamp), seq=of(one.seq))], one.stamp)
            for one in states
        ])  # fmt: skip
    assert answers[0] == answers[1]


@pytest.mark.parametrize(
    "thing", [None, {}, "thumb", dataclasses.replace(FingertipState(0, "x", 0), finger=["x"])]
)
def test_what_is_no_state_of_a_finger_is_counted_and_answered_by_nothing(thing, hand):
    hand.reset(ControlSettings())
    hand.rejected.clear()
    assert hand.step([thing], MS) == []
    assert hand.rejected == {"unknown finger": 1}
