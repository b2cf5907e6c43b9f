"""A tick passes by a finger that runs compiled exactly as long as its objects would do nothing."""

from copy import deepcopy

import numpy as np
import pytest

from validation.compiled_finger import Log, Replay, hostile
from vegrip.grip.compiled_finger import CompiledFinger
from vegrip.grip.node import GraspForce
from vegrip.messages import Condition

FRAMES = 400
PERIODS = (0.02, 0.2)
NEAR_NS = (-1, 0, 1)


def has_nothing_to_do(node: GraspForce, name: str, now: int) -> bool:
    """Return whether a tick does nothing, by the objects; they are in force from then on."""
    node.take_back(name)
    finger = node.fingers[name]
    is_due = finger.controller.due(now)
    return deepcopy(finger.watchdog).tick(now) <= Condition.DEGRADED and not is_due


def edges(compiled: CompiledFinger) -> list[int]:
    """Return times [ns] around which a finger stops being quiet."""
    memory = compiled.memory
    silence = memory["INPUT_HEARD"] + int(memory["RULE_TIME_OUT"])
    renewal = memory["TURN_COMMANDED"] + memory["SETUP_RENEWAL"]
    return [edge + off for edge in (silence, renewal) for off in NEAR_NS]


@pytest.mark.parametrize("seed", [-1, 3, 4])
def test_a_finger_is_quiet_to_the_nanosecond_when_its_objects_have_nothing_to_do(
    hand_log: Log, mode: str, seed: int
) -> None:
    replay = Replay(hand_log if seed < 0 else hostile(hand_log, seed), mode)
    rng, seen = np.random.default_rng(1), {True: 0, False: 0}
    for event in replay.log.events[:FRAMES]:
        replay.meet(event)
        if rng.random() > 0.1:
            continue
        for name, compiled in replay.node.compiled_fingers.items():
            if not compiled.lend(replay.node.controller, PERIODS):
                continue
            for now in (event.now, *edges(compiled)):
                assert compiled.lend(replay.node.controller, PERIODS)
                quiet = compiled.is_quiet(now)
                assert quiet == has_nothing_to_do(replay.node, name, now)
                seen[quiet] += 1
    assert min(seen.values()) > 50
