"""A tick passes by a finger exactly as long as it has nothing to do there."""

import numpy as np
import pytest

from validation.compiled_finger import Log, Replay, hostile
from vegrip.grip.finger import GraspFinger
from vegrip.messages import Condition

FRAMES = 400
NEAR_NS = (-1, 0, 1)


def edges(finger: GraspFinger) -> list[int]:
    """Return times [ns] around which a finger stops being quiet."""
    memory = finger.memory
    silence = memory["INPUT_RECEIVED"] + int(memory["RULE_TIME_OUT"])
    renewal = memory["TURN_COMMANDED"] + memory["SETUP_RENEWAL"]
    return [edge + off for edge in (silence, renewal) for off in NEAR_NS]


def watched(finger: GraspFinger, now: int) -> bool:
    """Return whether a tick finds nothing; it leaves no trace."""
    kept = finger.memory.f.copy(), finger.memory.t.copy()
    is_due = finger.watch(now)
    nothing = finger.condition <= Condition.DEGRADED and not is_due
    finger.memory.f[:], finger.memory.t[:] = kept
    return nothing


@pytest.mark.parametrize("seed", [-1, 3, 4])
def test_a_finger_is_quiet_to_the_nanosecond_when_a_tick_finds_nothing(
    hand_log: Log, mode: str, seed: int
) -> None:
    replay = Replay(hand_log if seed < 0 else hostile(hand_log, seed), mode)
    rng, seen = np.random.default_rng(1), {True: 0, False: 0}
    for event in replay.log.events[:FRAMES]:
        replay.meet(event)
        if rng.random() > 0.1:
            continue
        for finger in replay.node.fingers.values():
            for now in (event.now, *edges(finger)):
                quiet = finger.is_quiet(now)
                assert quiet == watched(finger, now)
                seen[quiet] += 1
    assert min(seen.values()) > 50
