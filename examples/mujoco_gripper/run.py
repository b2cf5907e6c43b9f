"""Hold a glass in MuJoCo while it is filled, with the controller that you would embed.

Usage: python examples/mujoco_gripper/run.py [SECONDS]
"""

import sys
from dataclasses import replace
from importlib.util import find_spec

import numpy as np

import vegrip
from vegrip.trials.closed_loop import GRASPS
from vegrip.virtual.disturbance import AddedMass
from vegrip.virtual.hand import TRUTHS

if find_spec("mujoco") is None:
    print("skipped: MuJoCo is not installed; pip install 'vegrip[mujoco]'")
    sys.exit(77)

from vegrip.bridges.mujoco_plant import MujocoHand, Shape

DURATION = float(sys.argv[1]) if len(sys.argv) > 1 else 6.0
PERIOD = 0.002  # [s] of the sensors

pinch = GRASPS["pinch"]
glass = replace(pinch.plate, mass=0.08, offset_x=0.0, offset_y=-0.01)
tip = replace(pinch.tip, friction=0.5)
filling = AddedMass(2.0, 2.0 * DURATION, 0.2)  # 0.2 kg of water
hand = MujocoHand(replace(pinch, plate=glass, tip=tip), 1, (filling,), Shape("cylinder", (0.03, 0.06)))

settings = vegrip.ControlSettings(limits=vegrip.LimitSettings(max_force=15.0))
grip = vegrip.GripController(hand.fingers, model=vegrip.paper_model(tip_radius=9e-3), settings=settings)
held = np.full(2, np.nan)
while hand.time < DURATION and not hand.dropped:
    states = [s for sample in hand.advance(PERIOD, held) for s in sample.states(hand.fingers)]
    for command in grip.step(states, round(hand.time * 1e9)):
        held[hand.fingers.index(command.finger)] = command.normal_force
    if round(hand.time / PERIOD) % 500 == 0:
        bound = min(grip.margin(finger).lower_bound for finger in hand.fingers)
        true = 1.0 - hand.truths()[:, TRUTHS.index("utilisation")].max()
        print(
            f"{hand.time:3.0f} s: {hand.contact(1)[0]:5.2f} N, margin at least {bound:.2f}, true {true:.2f}"
        )

print(f"{'dropped' if hand.dropped else 'held'}, {hand.slips} slips, moved by {1e3 * hand.shift:.2f} mm")
sys.exit(hand.dropped)
