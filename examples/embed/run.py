"""Grip control inside your own 1 kHz loop, without any bus.

The loop is the part between the lines; below it stands what your robot already has, here a tip that is
pressed 1 mm deep in half a second, held, and pulled sideways by a load that grows.
"""

from collections.abc import Iterator

import numpy as np

import vegrip

# ---------------------------------------------------------------------------------------------------------
fingertip = vegrip.paper_model(tip_radius=8e-3)  # or vegrip.read_model(Path("my_fingertip.toml"))
noise = vegrip.SensorNoise(normal_force=0.01, displacement=5e-6)
settings = vegrip.ControlSettings(limits=vegrip.LimitSettings(max_force=8.0))  # [N] that tip and object bear
hand = vegrip.GripController(("index",), model=fingertip, noise=noise, settings=settings)


def control_step(sensed: list[vegrip.FingertipState], now: int) -> list[vegrip.ForceCommand]:
    """Called every millisecond, also when no state came; return the forces to apply [N]."""
    return hand.step(sensed, now)


# ---------------------------------------------------------------------------------------------------------


def robot(seconds: float = 3.0) -> Iterator[vegrip.FingertipState]:
    """A fingertip that is not quite the one the estimator was told of, with its sensors."""
    rng = np.random.default_rng(7)
    t = np.arange(0.0, seconds, 1e-3)
    depth = np.interp(t, [0.0, 0.2, 0.7], [-1e-4, -1e-4, 1e-3])
    stiffer = fingertip.with_value("K", 1.2 * fingertip.values["K"].value)
    force = stiffer.simulate(t, depth).normal_force
    load = 0.25 * force * np.clip(t - 0.7, 0.0, 1.5)
    for i in range(t.size):
        yield vegrip.FingertipState(
            stamp=int(i * 1e6),
            finger="index",
            seq=i,
            normal_force=force[i] + 0.01 * rng.standard_normal(),
            tangential_force_x=load[i] + 0.01 * rng.standard_normal(),
            tangential_force_y=0.01 * rng.standard_normal(),
            torque_z=1e-4 * rng.standard_normal(),
            displacement=depth[i] + 5e-6 * rng.standard_normal(),
            slip=0.0,
        )


def main() -> None:
    """Run the loop and print what it knows four times a second."""
    print("time [s]   N [N]           a [mm]          mu           margin > bound   command [N]")
    for sensed in robot():
        (command,) = control_step([sensed], sensed.stamp)
        if sensed.seq % 250 == 249:
            asked = f"{command.normal_force:10.2f} {command.reason.name}"
            print(f"{sensed.stamp / 1e9:8.2f}  {describe('index')}  {asked}")


def describe(finger: str) -> str:
    """One line of what is known."""
    margin, c = hand.margin(finger), hand.contact(finger)
    parts = [f"{c.normal_force.value:6.3f} +- {c.normal_force.std:5.3f}"]
    parts += [f"{1e3 * c.contact_radius.value:6.3f} +- {1e3 * c.contact_radius.std:5.3f}"]
    parts += [f"{c.friction_coefficient.value:5.2f} +- {c.friction_coefficient.std:4.2f}"]
    parts += [f"{margin.margin.value:6.2f} > {margin.lower_bound:5.2f}"]
    return "  ".join(parts)


if __name__ == "__main__":
    main()
