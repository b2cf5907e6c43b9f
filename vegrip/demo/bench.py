"""The demonstration as a bench: pads, or a sensor at the wrist, and a gripper, each behind its own device.

The virtual hand is a gripper whose jaws press as its drive is commanded; the object is filled, shaken and
pulled.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from vegrip.config import build, toml_value
from vegrip.connect.parts import FORCES, benches
from vegrip.demo.product import free_port
from vegrip.errors import InputError
from vegrip.estimator import Sensors
from vegrip.grip.parameters import GraspParameters
from vegrip.grip.safety.drive import DriveLimits
from vegrip.runtime.launch_file import NodeConfig
from vegrip.transport.hands.bench import JAWS
from vegrip.transport.hands.drive_steps import range_of, step_above
from vegrip.transport.maps.map_text import changed_text
from vegrip.transport.maps.products import about, map_of, names, virtual_text
from vegrip.trials.closed_loop import SETTLED_S, Course, Scenario
from vegrip.trials.fronts import least_forces
from vegrip.virtual import Disturbance, HandSettings
from vegrip.virtual.disturbance import AddedMass, Push, Shake
from vegrip.whole_file import write_whole

FIRM: Final = 4.0
"""Times as stiff as the usual tip: pads that bear what a gripper presses with."""
GRIPPER_KG: Final = 0.9  # of a 2F-85 with its coupling (data sheet)
WRIST: Final = "wrist="
FRICTION_STD: Final = 0.1
"""Of ln mu: friction as `vegrip calibrate` measures it of a pad on one material. Not stated, it is not known
by a factor of two, and without a slip channel it is not learned."""
CALIBRATED: Final = Sensors(tangential_gain=1.0, tangential_gain_std=0.03)
"""Of the pads' tangential forces, after `vegrip calibrate --weight`."""


@dataclass(frozen=True)
class BenchScenario(Scenario):
    """An object in a gripper, and its fate."""

    @property
    def settings(self) -> HandSettings:
        hand = super().settings
        tip = replace(hand.tip, reference_force=FIRM * hand.tip.reference_force)
        plate = replace(hand.plate, mass=0.4, offset_x=0.0, offset_y=-2e-3)
        actuator = replace(hand.actuator, initial_force=20.0, force_limit=60.0, close_time=1.5)
        sensor = replace(hand.sensor, slip_sensor=False)
        return replace(hand, tip=tip, plate=plate, actuator=actuator, sensor=sensor)

    @property
    def events(self) -> tuple[Disturbance, ...]:
        return (
            AddedMass(0.15 * self.duration, 0.6 * self.duration, 0.7),
            Shake(0.3 * self.duration, 0.15 * self.duration, 4.0, 2.0, math.pi / 2),
            Push(0.5 * self.duration, 0.1 * self.duration, 3.0, -6.0),
            Push(0.8 * self.duration, 0.1 * self.duration, 0.0, -5.0),
        )


@dataclass(frozen=True)
class BenchProduct:
    """A bench that is demonstrated; as :class:`~vegrip.demo.product.Product`."""

    name: str
    node: NodeConfig
    drive: DriveLimits
    has_pads: bool = True

    @property
    def fingers(self) -> tuple[str, ...]:
        return self.node.fingers

    def scenario(self, seed: int, duration: float) -> BenchScenario:
        return BenchScenario(seed, duration, "pinch", relaxes_slowly=False, names=self.fingers)

    def parameters(self, scenario: Scenario) -> GraspParameters:
        """Return the parameters of the launch file, with what a calibration finds of these pads."""
        found = build(GraspParameters, self.node.parameters, self.name)
        tip = scenario.settings.tip
        error = float(np.random.default_rng([scenario.seed, 7]).normal(0.0, FRICTION_STD))
        friction = replace(
            found.friction,
            coefficient=tip.friction * math.exp(error),
            coefficient_std=FRICTION_STD,
            load_exponent=0.0,
            load_exponent_std=0.0,
        )
        first = {"radius": scenario.settings.opposing_radius}
        return replace(
            found,
            tip=replace(found.tip, radius=tip.radius),
            tips={scenario.settings.fingers[0]: first},
            friction=friction,
            sensors=CALIBRATED if self.has_pads else found.sensors,
            estimator=replace(found.estimator, hold="force"),
        )

    def transports(self, folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:  # noqa: ARG002
        """Return the transports of the virtual devices and of the node."""
        return {**self.node.transport, "virtual": True}, dict(self.node.transport)

    def describe(self) -> str:
        return (
            f"{self.name}: the gripper makes {range_of(self.drive)}, {1e3 * self.drive.delay:.0f} ms late; "
            "the object is filled, shaken and pulled; friction is known to 10 %"
        )

    def figures(self, course: Course) -> dict[str, float]:
        """Return the slide [m], the mean force [N] and that over what the steps allow at best [-]."""
        kept = np.array(course.time) >= SETTLED_S
        need = least_forces(course).max(axis=1)[kept]
        force = np.array(course.force)[kept, 0]
        best = np.array([step_above(self.drive, one) for one in need])
        return {
            "largest_slide": course.slid,
            "mean_force": float(force.mean()),
            "mean_need": float(need.mean()),
            "best_by_steps": float(best.mean()),
            "force_over_best": float(force.mean() / best.mean()),
        }

    def summary(self, course: Course) -> str:
        said = self.figures(course)
        return (
            f"{self.name} (simulated): {'dropped' if course.dropped else 'held'}, slid by "
            f"{1e3 * said['largest_slide']:.2f} mm at most; {said['mean_force']:.1f} N in the mean where "
            f"{said['mean_need']:.1f} N just hold: {said['force_over_best']:.2f} times the "
            f"{said['best_by_steps']:.1f} N that the steps of the drive allow at best"
        )


def open_bench_product(text: str, folder: Path) -> BenchProduct:
    """Return the bench ``SENSOR+DRIVE`` or ``wrist=SENSOR+DRIVE``; its launch file goes to ``folder``."""
    sensor, plus, drive = text.partition("+")
    if not plus:
        raise InputError(f"--bench {text!r}: name a sensor and a drive, as papillarray+robotiq")
    is_at_wrist = sensor.startswith(WRIST)
    sensors = [name for name in names() if not about(name)["commands"]]
    if is_at_wrist:
        sensors = [name for name in sensors if set(about(name)["channels"]).issuperset(FORCES)]
    else:
        sensors = _measured(sensor, sensors)
    feels = _chosen(sensor.removeprefix(WRIST), sensors, "sensor")
    presses = _chosen(drive, [name for name in names() if not about(name)["channels"]], "drive")
    folder.mkdir(parents=True, exist_ok=True)
    lines = [f"drive = {toml_value(_at(presses, 'drive', folder))}", f"serves = {toml_value(JAWS)}"]
    if is_at_wrist:
        load = {"from": _at(feels, "wrist", folder), "mass": GRIPPER_KG}
        lines.append(f"load = {toml_value(load)}")
    else:
        pads = [f"{side}={_at(feels, side, folder)}" for side in JAWS]
        lines.append(f"sensors = {toml_value(pads)}")
    path = folder / "bench.toml"
    write_whole(path, "\n".join(lines) + "\n")
    ((node, bench),) = benches(path)
    assert bench.drive is not None  # noqa: S101 (named above)
    return BenchProduct(f"{feels} + {presses}", node, bench.drive.plan.hand.drive, bool(bench.sensors))


def _at(product: str, place: str, folder: Path) -> str:
    """Return the product at a port of its own; what is to be measured of it is that of its virtual device."""
    kind = about(product)["carrier"].partition(" ")[0]
    if kind == "can":
        raise InputError(f"--bench: {product} is on a CAN bus, which two of them would have to share")
    port = str(folder / f"tty_{place}") if kind == "serial" else f"127.0.0.1:{free_port(kind)}"
    if not about(product)["to_measure"]:
        return f"{product}@{port}"
    path, text = folder / f"{place}.toml", virtual_text(map_of(product), has_drive=False)
    write_whole(path, changed_text(text, [(["transport", "address"], port)], "of the demonstration"))
    return str(path)


def _measured(word: str, sensors: Sequence[str]) -> list[str]:
    """Return those of which nothing is to be measured: pads of the others would need a map each."""
    known = [name for name in sensors if not about(name)["to_measure"]]
    others = [name for name in sensors if word in name and name not in known]
    if others and not any(word in name for name in known):
        raise InputError(
            f"--bench: pads of {others[0]} have values to be measured first, as `vegrip connect --hand "
            f"{others[0]}` says; there are {', '.join(known)}"
        )
    return known


def _chosen(word: str, known: Sequence[str], what: str) -> str:
    """Return the product whose name has ``word`` in it, the shortest of several."""
    found = [name for name in known if word in name]
    if not word or not found:
        raise InputError(f"--bench: there is no {what} {word!r}; there are {', '.join(known)}")
    return min(found, key=len)
