"""Hold an object with a constant grip for 20 s while it is disturbed, and draw what really happens.

Usage: python examples/virtual_hand/run.py [PICTURE.png] [GRIP_FORCE_PER_FINGER_N]
"""

import sys
import time as wall
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from vegrip.virtual import HandSettings, VirtualHand, disturbances

DURATION = 20.0
picture = Path(sys.argv[1]) if len(sys.argv) > 1 else None
grip = float(sys.argv[2]) if len(sys.argv) > 2 else 1.2

settings = HandSettings()
weight = settings.plate.mass * settings.plate.gravity
hand = VirtualHand(settings, seed=1, events=disturbances(2, DURATION, weight=weight))
command = dict.fromkeys(hand.fingers[1:], grip)

time, force, load, margin, shift, slipping = [], [], [], [], [], []
spent = 0.0
while hand.time < DURATION and not hand.dropped:
    start = wall.perf_counter()
    hand.step(0.01, command)
    spent += wall.perf_counter() - start
    truth = [hand.truth(finger) for finger in hand.fingers]
    time.append(hand.time)
    force.append([t.normal_force for t in truth])
    load.append([np.hypot(t.tangential_force_x, t.tangential_force_y) for t in truth])
    margin.append([t.margin for t in truth])
    shift.append(hand.shift)
    slipping.append(any(t.sliding for t in truth))

print(f"{hand.time:.1f} s, {hand.slips} slips, {'dropped' if hand.dropped else 'held'}")
print(f"least margin {np.min(np.array(margin)[150:]):.3f}, moved by {1e3 * np.hypot(*shift[-1][:2]):.2f} mm")

print(f"simulated {hand.time / spent:.1f} times faster than real time")

if picture is not None:
    figure, axes = plt.subplots(4, 1, figsize=(9, 9), sharex=True, layout="constrained")
    panels = (force, "normal force [N]"), (load, "tangential force [N]"), (margin, "slip margin")
    for axis, (rows, label) in zip(axes, panels, strict=False):
        axis.plot(time, rows, lw=0.9, label=hand.fingers)
        axis.set_ylabel(label)
    axes[0].legend(ncols=5, fontsize="small", loc="lower right")
    axes[2].set_ylim(-0.05, 1.05)
    axes[3].plot(time, 1e3 * np.array(shift)[:, :2], lw=0.9, label=["x [mm]", "y [mm]"])
    axes[3].plot(time, np.degrees(np.array(shift)[:, 2]), lw=0.9, label="angle [deg]")
    axes[3].set(ylabel="object moved", xlabel="time [s]")
    axes[3].legend(fontsize="small")
    for event in hand.events:
        axes[1].axvspan(event.start, event.start + event.duration, color="0.9", zorder=0)
        axes[1].text(event.start, axes[1].get_ylim()[1], type(event).__name__, fontsize=7, va="top")
    for axis in axes[2:]:
        axis.fill_between(
            time, 0, 1, slipping, color="tab:red", alpha=0.3, transform=axis.get_xaxis_transform()
        )
    figure.savefig(picture, dpi=110)
