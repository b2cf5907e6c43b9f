"""Single stages of the finger step as plain Python runs them, to test their laws; each has its own memory."""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np

from vegrip.estimator.layout import layout_of
from vegrip.estimator.memory import CHANNELS, FingerMemory
from vegrip.grip.compiled import finger_module
from vegrip.grip.finger import FRESH, UNKNOWN_AT_FIRST, UNRECEIVED
from vegrip.grip.layout import FingerLayout, write_choice, write_rules
from vegrip.grip.policies.demand import Demand
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.safety import FailSafeSettings, LimitSettings, WatchdogSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Condition, FingertipState, Reason
from vegrip.model import paper_model
from vegrip.types import Floats

MODEL = paper_model(8e-3)
FINGER = FingerLayout(layout_of(MODEL), late=3, history=5, is_shared=True)
KERNELS: ModuleType = finger_module(MODEL, FINGER, mode="python")

OF_WHOLES = ("TURN_", "CLOCK_", "NEED_", "SAMPLE_", "SETUP_", "INPUT_", "NEWS_", "CHOICE_")


def put(kernels: ModuleType, f: Floats, t: Any, **values: float) -> None:
    """Set numbers by name: real ones in ``f``, whole ones in ``t``."""
    for name, value in values.items():
        (t if name.startswith(OF_WHOLES) else f)[getattr(kernels, name)] = value


class Stage:
    """A fresh memory with the rules of some settings."""

    def __init__(self, **settings: Any) -> None:
        self.memory = FingerMemory(FINGER)
        for name, value in {**FRESH, **UNRECEIVED}.items():
            self.memory[name] = value
        for name in UNKNOWN_AT_FIRST:
            self.memory.section(name)[:] = math.nan
        self.apply(ControlSettings(**settings))
        self.f, self.t = self.memory.f, self.memory.t

    def apply(self, settings: ControlSettings) -> None:
        """Go by other settings."""
        write_rules(self.memory, settings)
        write_choice(self.memory, settings)

    def put(self, state: FingertipState) -> None:
        """Let this be the present state."""
        self.memory["NEWS_SEQ"], self.memory["NEWS_STAMP"] = state.seq, state.stamp
        self.memory.section("STATE")[:] = [getattr(state, name) for name in CHANNELS]

    def demand(self, demand: Demand) -> None:
        """Let this be the demand."""
        given = demand.least_force, demand.tangential_force, demand.torque, demand.margin_bound
        self.memory.section("DEMAND")[:] = given
        self.memory.section("NEED")[:3] = demand.in_contact, demand.slipping, demand.trusted


class Watchdog(Stage):
    """The supervision of the input."""

    def __init__(self, settings: WatchdogSettings) -> None:
        super().__init__(watchdog=settings)
        self.settings = settings

    def accept(self, state: FingertipState, now: int) -> bool:
        self.put(state)
        return bool(KERNELS.accept_state(self.f, self.t, now))

    def tick(self, now: int) -> Condition:
        KERNELS.watch_silence(self.f, self.t, now)
        return self.condition

    def corrupt(self, now: int) -> None:
        KERNELS.note_broken(self.t, now)

    @property
    def condition(self) -> Condition:
        return Condition(self.memory["INPUT_CONDITION"])

    @property
    def doubtful(self) -> bool:
        return (False, True)[self.memory["INPUT_DOUBTFUL"]]

    @property
    def lost(self) -> frozenset[str]:
        bits = self.memory["INPUT_LOST"]
        return frozenset(name for i, name in enumerate(CHANNELS) if bits >> i & 1)

    @property
    def faults(self) -> dict[Condition, int]:
        counts = zip(Condition, self.memory.section("FAULTS").tolist(), strict=True)
        return {condition: count for condition, count in counts if count}


class StuckNoise(Stage):
    """Whether the noise of a force has vanished; of another one, while the finger presses with 2 N or so."""

    def __init__(self, channel: str = "normal_force", pressed: float = 2.0) -> None:
        super().__init__()
        self._now, self._channel, self._pressed = 0, f"STATE_{channel.upper()}", pressed
        self.memory.section("STATE")[:] = math.nan

    def vanished(self, force: float, chance: float) -> bool:
        self._pressed, self._now = -self._pressed, self._now + 2_000_000
        self.memory["STATE_NORMAL_FORCE"] = abs(self._pressed) + 0.01 * (self._pressed > 0.0)
        self.memory[self._channel], self.memory["RULE_FROZEN_CHANCE"] = force, chance
        return bool(KERNELS.noise_vanished(self.f, self.t, self._now))


class Policy(Stage):
    """A policy that the step has."""

    def __init__(self, name: str, **settings: Any) -> None:
        super().__init__(policy=name, **settings)
        KERNELS.forget_grip(self.f, self.t)

    def wanted(self, held: float, demand: Demand, dt: float) -> tuple[float, Reason]:
        self.demand(demand)
        force, reason = KERNELS.asked_force(self.f, self.t, held, dt)
        return float(force), Reason(int(reason))


def margin_grip(settings: GripSettings, *, learning: bool = False) -> Policy:
    made = Policy("margin", grip=settings)
    made.memory["SETUP_SHARES"] = learning
    return made


class FailSafe(Stage):
    """Hold, then ramp."""

    def __init__(self, settings: FailSafeSettings) -> None:
        super().__init__(fail_safe=settings)

    def command(self, held: float, dt: float, holding: Reason) -> tuple[float, Reason]:
        self.memory["GRIP_HELD"] = self.memory["GRIP_REQUIRED"] = held
        KERNELS.hold_then_ramp(self.f, self.t, dt, int(holding))
        return self.memory["GRIP_REQUIRED"], Reason(self.memory["TURN_REASON"])

    def recovered(self) -> None:
        KERNELS.end_fault(self.f)

    @property
    def active(self) -> bool:
        return bool(KERNELS.is_at_fault(self.f))


class Takeover(Stage):
    """The bound of the least force after a contact was met in its middle."""

    def __init__(self, ramp: FailSafeSettings) -> None:
        super().__init__(fail_safe=ramp)

    def begin(self, force: float, demand: Demand, arm: float, now: int) -> None:
        self.demand(demand)
        with np.errstate(all="ignore"):
            KERNELS.begin_transfer(self.f, self.t, force, arm, now)

    def bounded(self, least: float, demand: Demand, now: int) -> float:
        self.demand(replace(demand, least_force=least))
        with np.errstate(all="ignore"):  # the kernels compute as IEEE 754 does
            KERNELS.bound_takeover(self.f, self.t, now)
        return float(self.memory["DEMAND_LEAST"])


class Closing(Stage):
    """What is kept of the force of a close until a load is felt; each step is one state."""

    def kept(self, force: float, load: float = 0.0, *, held: float = 0.5, touches: bool = True) -> float:
        self.memory["STATE_NORMAL_FORCE"] = force
        self.memory["GRIP_HELD"] = self.memory["GRIP_REQUIRED"] = held
        self.demand(Demand(0.1, load, 0.0, in_contact=touches, trusted=True))
        KERNELS.hold_unloaded(self.f, self.t)
        return float(self.memory["GRIP_KEPT"])


def limit_force(
    wanted: float, reason: Reason, held: float, dt: float, limits: LimitSettings
) -> tuple[float, Reason]:
    stage = Stage(limits=limits)
    stage.memory["GRIP_HELD"] = held
    force, why = KERNELS.limited(stage.f, wanted, math.nan, int(reason), dt)
    return float(force), Reason(int(why))


def clamp_force(force: float, limits: LimitSettings) -> float:
    return float(KERNELS.clamped(Stage(limits=limits).f, force))


def balance_forces(needs: Mapping[str, float], thumb: str) -> dict[str, float]:
    """Return the share of every finger; ``needs`` are NaN for fingers without a command."""
    names, stage = list(needs), Stage()
    stage.memory["SETUP_FINGERS"] = len(names)
    stage.memory["SETUP_THUMB"] = names.index(thumb) if thumb in names else -1
    g, shares = np.array([needs[name] for name in names]), {}
    for i, name in enumerate(names):
        stage.memory["SETUP_FINGER"] = i
        shares[name] = float(KERNELS.balanced_force(stage.t, g))
    return shares
