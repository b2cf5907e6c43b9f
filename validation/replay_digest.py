"""A digest of every number that estimator and grip node say over fixed sequences, faults among them.

Usage: ``python -m validation.replay_digest``. Two versions of the code that print the same compute the
same, to the bit: estimates, margins, least forces, health, covariances and commands of each sequence.
"""

import hashlib
import json
import math
import struct
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, replace
from typing import Any

import numpy as np

from vegrip.effects import effect
from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise
from vegrip.messages import FingertipState, Message
from vegrip.model import ContactModel, paper_model
from vegrip.runtime import NodeContext
from vegrip.runtime.node import find_program

RADIUS_M = 8e-3
STATE_RATE_HZ = 500
STATE_PERIOD_NS = 1_000_000_000 // STATE_RATE_HZ
REPORT_EVERY = 5  # states between two margins, least forces and looks at the health
EFFECTS = {
    "base": (),
    "memory": ("mullins_softening", "rate_stiffening"),
    "surface": ("load_dependent_friction",),
}
KNOTS_S = (0.0, 0.4, 0.9, 2.0, 2.3, 2.6, 3.0, 3.2, 4.4, 4.6, 5.0)
DEPTHS_M = (-3e-4, -3e-4, 9e-4, 9e-4, 5e-4, 5e-4, -2e-4, 8e-4, 1e-3, -3e-4, -3e-4)

States = list[FingertipState]
Fault = Callable[[States], States]


def measured(model: ContactModel, finger: str = "thumb", seed: int = 0) -> States:
    """Return the states of a noisy fingertip that presses, holds, slips, lets go and presses again."""
    rng, noise = np.random.default_rng(seed), SensorNoise()
    t = np.arange(round(KNOTS_S[-1] * STATE_RATE_HZ)) / STATE_RATE_HZ
    depth = np.interp(t, KNOTS_S, DEPTHS_M)
    contact = model.simulate(t, depth)
    sliding = (np.abs(t - 1.6) < 0.03) & (contact.normal_force > 0.0)
    limit = contact.friction_coefficient * contact.normal_force
    load = np.where(sliding, 1.0, 0.5 + 0.3 * np.sin(3.0 * t)) * limit
    force = contact.sensed_force + noise.normal_force * rng.standard_normal(t.size)
    moved = depth + 2e-5 + noise.displacement * rng.standard_normal(t.size)
    along = load + noise.tangential_force * rng.standard_normal(t.size)
    torque = 1e-3 * load + noise.torque_z * rng.standard_normal(t.size)
    radius = contact.contact_radius + noise.contact_radius * rng.standard_normal(t.size)
    rows = zip(force, along, torque, moved, sliding, radius, strict=True)
    return [
        FingertipState(
            stamp=i * STATE_PERIOD_NS,
            finger=finger,
            seq=i,
            normal_force=float(N),
            tangential_force_x=float(f),
            tangential_force_y=0.1,
            torque_z=float(moment),
            displacement=float(d),
            temperature=25.0,
            slip=float(slips),
            slip_speed=2e-3 if slips else 0.0,
            contact_radius=float(a) if i % 3 == 0 else math.nan,
        )
        for i, (N, f, moment, d, slips, a) in enumerate(rows)
    ]


def within(begin_s: float, end_s: float, **values: Any) -> Fault:
    """Return a fault that puts other values between two times."""

    def changed(states: States) -> States:
        first, last = round(begin_s * STATE_RATE_HZ), round(end_s * STATE_RATE_HZ)
        return [replace(s, **values) if first <= i < last else s for i, s in enumerate(states)]

    return changed


def missing(begin_s: float, end_s: float) -> Fault:
    """Return a fault that drops the states between two times."""
    first, last = round(begin_s * STATE_RATE_HZ), round(end_s * STATE_RATE_HZ)
    return lambda states: [*states[:first], *states[last:]]


def late(states: States) -> States:
    """Return the states, every fiftieth five places too late."""
    out = list(states)
    for i in range(50, len(out) - 6, 50):
        out.insert(i + 5, out.pop(i))
    return out


def frozen(states: States) -> States:
    """Return the states, all values standing still for 0.4 s."""
    kept = states[700]
    return [replace(kept, stamp=s.stamp, seq=s.seq) if 700 <= i < 900 else s for i, s in enumerate(states)]


def set_back(states: States) -> States:
    """Return the states, the sender's clock a second behind from the middle on."""
    return [replace(s, stamp=s.stamp - 1_000_000_000) if i > 1000 else s for i, s in enumerate(states)]


FAULTS: dict[str, Fault] = {
    "none": list,
    "force NaN": within(1.0, 1.4, normal_force=math.nan),
    "displacement lost": within(0.7, 2.1, displacement=math.nan),
    "all NaN": within(1.0, 1.2, normal_force=math.nan, displacement=math.nan, tangential_force_x=math.nan),
    "force wrong for a sample": within(1.2, 1.202, normal_force=-4.0),
    "force wrong": within(1.2, 1.7, normal_force=15.0),
    "force absurd": within(1.2, 1.21, normal_force=-1e300),
    "displacement wrong": within(1.2, 1.7, displacement=2e-3),
    "displacement wrong for long": within(1.2, 4.2, displacement=3e-3),
    "torque infinite": within(1.2, 1.4, torque_z=math.inf),
    "slip stuck": within(1.2, 2.2, slip=1.0, slip_speed=1e-2),
    "radius wrong": within(1.0, 2.0, contact_radius=8e-3),
    "gap": missing(1.0, 1.6),
    "gap in the air": missing(2.9, 3.1),
    "begins in contact": missing(0.0, 1.2),
    "late": late,
    "frozen": frozen,
    "clock set back": set_back,
}


def numbers(value: object) -> Iterator[float]:
    """Yield all numbers in a message or a nest of tuples; names and texts are left out."""
    if isinstance(value, bool | int | float):
        yield float(value)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from numbers(one)


def digest(values: Sequence[float]) -> str:
    """Return a digest of the bytes of ``values``; every NaN counts as the same."""
    same = (math.nan if math.isnan(x) else x for x in values)
    return hashlib.sha256(struct.pack(f"<{len(values)}d", *same)).hexdigest()[:16]


def told_by_estimator(estimator: ContactEstimator, states: States) -> list[float]:
    """Return every number that the estimator says of the states."""
    estimator.reset()
    told: list[float] = []
    for i, state in enumerate(states):
        told += numbers(astuple(estimator.update(state)))
        if i % REPORT_EVERY == 0:
            told += numbers(astuple(estimator.slip_margin()))
            told += numbers(astuple(estimator.health()))
            told += [estimator.least_force(0.15), estimator.least_force(0.3, 0.99)]
    told += estimator.covariance.ravel().tolist()
    for symbol in estimator.model.parameters:
        told += numbers(astuple(estimator.value(symbol)))
    return [*told, estimator.refused, estimator.late, int(estimator.named["COUNT_RESTARTS"])]


def told_by_node(hands: Sequence[States]) -> list[float]:
    """Return every number that the grip node answers to states, each 0.2 ms after its stamp."""
    fingers = tuple(states[0].finger for states in hands)
    settings = {"suspects": False, "tip": {"radius": RADIUS_M}}
    node = find_program("grasp_force")(settings, NodeContext("grip", fingers=fingers))
    node.configure()
    node.activate()
    told: list[Message] = []
    for i in range(max(len(states) for states in hands)):
        now = i * STATE_PERIOD_NS + 200_000
        for states in hands:
            told += node.on_message(states[i], now) if i < len(states) else ()
        told += node.on_tick(now + 500_000)
    return [number for message in told for number in numbers(astuple(message))]


def digests() -> Iterator[tuple[str, str]]:
    """Yield the name of each sequence and its digest."""
    for kind, added in EFFECTS.items():
        model = paper_model(RADIUS_M)
        for name in added:
            model = model.with_effect(effect(name))
        for hold in ("position", "mixed") if kind == "base" else ("position",):
            estimator = ContactEstimator(model, SensorNoise(), EstimatorSettings(hold=hold))
            for name, fault in FAULTS.items():
                told = told_by_estimator(estimator, fault(measured(model)))
                yield f"estimator, {kind}, {hold}: {name}", digest(told)
    model = paper_model(RADIUS_M)
    for name, fault in FAULTS.items():
        hands = [fault(measured(model, "thumb", seed=1)), measured(model, "index", seed=2)]
        yield f"node: {name}", digest(told_by_node(hands))


def main() -> None:
    """Print the digests as JSON."""
    json.dump(dict(digests()), sys.stdout, indent=1)
    print()  # noqa: T201


if __name__ == "__main__":
    main()
