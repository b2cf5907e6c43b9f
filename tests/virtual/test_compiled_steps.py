"""The compiled steps of the virtual hand are those of the arrays."""

from dataclasses import replace

import numpy as np
import pytest

from tests.virtual.stepped_hand import SteppedHand
from vegrip.virtual import HandSettings, VirtualHand, disturbances
from vegrip.virtual.disturbance import Wetting
from vegrip.virtual.settings import FingertipSettings, SensorSettings, ThermalSettings

HAND = HandSettings()
CASES = {
    "as it is": HAND,
    "power law": replace(
        HAND, tip=FingertipSettings(relaxation="power_law", amplitudes=(0.4,), rates=(5.0,))
    ),
    "warm": replace(HAND, thermal=ThermalSettings(warming=True, time=2.0)),
    "two fingers, all sensors, coarse time": replace(
        HAND, fingers=("a", "b"), x=(0.0, 0.0), y=(0.0, 0.0), step=2e-3, rings=5, spokes=12,
        sensor=SensorSettings(rate=130.0, radius_sensor=True, slip_delay=0.03, dropout=0.1, jitter=1e-4),
    ),
}  # fmt: skip


def course(hand: VirtualHand, seed: int) -> tuple[np.ndarray, list[tuple[object, ...]]]:
    """Drive a hand until it has dropped the object; return its truth and its states."""
    rng, rows, states = np.random.default_rng(seed), [], []
    for turn in range(400):
        force = (1.6 if turn < 300 else 0.2) * rng.uniform(0.8, 1.2)
        silent = rng.random(len(hand.fingers)) < 0.02
        ask = {finger: force for finger, none in zip(hand.fingers, silent, strict=True) if not none}
        if turn % 50:
            ask.pop(hand.fingers[0], None)
        states += [tuple(getattr(s, name) for name in s.__slots__) for s in hand.step(0.0073, ask)]
        truths = [hand.truth(finger) for finger in hand.fingers]
        rows.append([[getattr(t, name) for name in t.__slots__] for t in truths])
    return np.array(rows, float), states


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("seed", [0, 1])
def test_truth_slips_and_states_are_those_of_the_arrays(case: str, seed: int) -> None:
    settings = CASES[case]
    events = (*disturbances(seed, 3.0, start=1.1, pause=0.3), Wetting(1.5, 0.6, 0.7))
    fast, slow = VirtualHand(settings, seed, events), SteppedHand(settings, seed, events)
    (truth, states), (expected, wanted) = course(fast, seed), course(slow, seed)
    assert fast.dropped
    assert (fast.slips, fast.dropped, fast.time) == (slow.slips, slow.dropped, slow.time)
    np.testing.assert_allclose(truth, expected, rtol=1e-7, atol=1e-11)
    assert [state[:3] for state in states] == [state[:3] for state in wanted]
    sensed, clean = (np.array([state[3:] for state in one], float) for one in (states, wanted))
    unequal = ~np.isclose(sensed, clean, rtol=1e-7, atol=1e-11, equal_nan=True)
    assert np.mean(unequal) < 1e-4  # a value on the edge between two steps of a sensor may go either way
