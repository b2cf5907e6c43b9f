"""Step a drive up and down on a stiff object, never above a stated force, and keep what the pads feel.

However it ends, the drive is commanded to open: at the end, on Ctrl-C, when a pad falls silent, when the
drive is lost or says that something is wrong, when more is felt than was stated, and when the pads disagree.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from vegrip.clock import NS, Clock
from vegrip.connect.drive_response import Change, DriveRun, Stage
from vegrip.connect.parts import benches
from vegrip.errors import DeviceError, InputError, UsageError
from vegrip.grip.safety.drive import DriveLimits
from vegrip.messages import FingertipState, ForceCommand, Reason, make_row
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.hands.bench import Bench
from vegrip.transport.hands.bench_endpoint import times_lost
from vegrip.transport.hands.jaw_balance import JawBalance

LEVELS: Final = 9
FINE_STEPS: Final = 32
FINER: Final = 4  # fine settings in a step that the map states
FINE_SHARE: Final = 1.0 / 200.0  # of the range, where the map states no step
DWELL_S: Final = 1.5  # [s] at a level
FINE_DWELL_S: Final = 0.4
DELAYS: Final = 6.0  # stated delays that are waited for at least
CLOSING_S: Final = 10.0  # [s] to close on the object
OPENING_S: Final = 0.5  # [s] for which the drive is commanded to open
FIRST_WORD_S: Final = 3.0  # [s] for the first state of a pad
SILENT_S: Final = 0.5  # [s] without a state of a pad
TOUCH_N: Final = 1.0  # [N] felt by every pad: the object is held
OVER: Final = 1.15
"""Times the stated force at which the sweep ends: a line that is extrapolated, and noise, stay below."""
NAP_S: Final = 1e-3  # [s] between two looks at the devices
RENEWED_S: Final = 0.05  # [s] between two commands
LIFETIME_S: Final = 0.5  # [s] of a command

Report = Callable[[str], None]


@dataclass(frozen=True)
class SweepPlan:
    """Which settings are asked for, and for how long each."""

    levels: tuple[float, ...]  # [N]
    fine: float  # [N] between two of the fine settings
    dwell: float  # [s]
    fine_dwell: float  # [s]
    most: float  # [N] that may be felt

    @property
    def seconds(self) -> float:
        """How long it takes, closing left out."""
        return 2 * len(self.levels) * self.dwell + FINE_STEPS * self.fine_dwell


def plan_sweep(drive: DriveLimits, most: float) -> SweepPlan:
    """Return the settings from the least of ``drive`` to ``most`` [N].

    Raises:
        UsageError: there is no range to measure in.

    """
    top = min(most, drive.maximum)
    low = drive.minimum or top / LEVELS
    step = max(drive.resolution, drive.hysteresis)
    if top - low < LEVELS * step or not low < top:
        raise UsageError(
            f"from {low:g} N, the least of the drive, to {top:g} N there is too little to measure in; at "
            f"least {low + LEVELS * step:g} N must be allowed: --normal-force, and limits.max_force in the "
            "launch file"
        )
    grid = drive.resolution or (top - low) / (LEVELS - 1)  # whole steps, so that rounding is the same at all
    each = math.floor((top - low) / (LEVELS - 1) / grid + 1e-9) * grid
    levels = tuple(low + number * each for number in range(LEVELS))
    fine = drive.resolution / FINER or FINE_SHARE * (top - low)
    wait = DELAYS * (drive.delay + (1.0 / drive.rate if drive.rate else 0.0))
    return SweepPlan(levels, fine, max(DWELL_S, wait), max(FINE_DWELL_S, wait), most)


def bench_of(path: Path) -> tuple[Bench, float]:
    """Return the parts of the hand in a launch file, and the largest force [N] that it states.

    Raises:
        InputError: no drive is a part of its own, or no pad feels what it presses.

    """
    for node, bench in benches(path):
        if bench.drive is not None and bench.sensors:
            return bench, float(node.parameters.get("limits", {}).get("max_force", math.inf))
    raise InputError(
        f"{path}: names no 'drive' with 'sensors' that feel what it presses; see docs/tutorials/bench.md"
    )


@contextmanager
def opened(bench: Bench, clock: Clock) -> Iterator["Rig"]:
    """Open the parts of a bench; leaving it opens the jaws first."""
    assert bench.drive is not None  # noqa: S101 (asked by bench_of)
    with ExitStack() as stack:
        parts = {
            name: stack.enter_context(source.open(source.text))
            for name, source in bench.parts.items()
            if source == bench.drive or source in bench.sensors
        }
        drive = next(parts[name] for name, source in bench.parts.items() if source == bench.drive)
        pads = [
            (parts[name], {theirs: ours for theirs, ours in source.names.items() if ours in bench.serves})
            for name, source in bench.parts.items()
            if source in bench.sensors
        ]
        rig = Rig(drive, bench.drive.commanded, pads, clock)
        stack.callback(rig.let_go)
        yield rig


class Rig:
    """A drive and the pads that feel it.

    Args:
        drive: that is commanded.
        fingers: as its map calls them.
        pads: endpoints that feel, each with its fingers and our names of them.
        clock: of all times; the loop waits by it.

    """

    def __init__(
        self,
        drive: Endpoint,
        fingers: Sequence[str],
        pads: Sequence[tuple[Endpoint, Mapping[str, str]]],
        clock: Clock,
    ) -> None:
        self._drive, self._fingers, self._pads, self._clock = drive, fingers, pads, clock
        self._felt: dict[str, float] = {ours: math.nan for _, names in pads for ours in names.values()}
        self._balance = JawBalance(*self._felt) if len(self._felt) == 2 else None
        self._is_holding, self._is_even = False, True
        self._received = dict.fromkeys(self._felt, clock.now() + round(FIRST_WORD_S * NS))  # [ns]
        self._lost, self._known = times_lost(self._drive), drive.device_faults
        self._setting, self._due, self._seq = math.nan, 1 << 62, 0  # nothing commanded yet
        self._time: list[float] = []
        self._force: list[float] = []
        self._changes: list[Change] = []
        self.most = math.inf  # [N] that may be felt

    @property
    def now(self) -> float:
        return self._clock.now() / NS

    def run(self, plan: SweepPlan, report: Report) -> DriveRun:
        """Go through all settings of ``plan``.

        Raises:
            DeviceError: a part was lost, or the drive says that something is wrong.
            InputError: nothing is between the jaws, more is felt than was stated, or the pads disagree.

        """
        self.most = plan.most
        self._close_on_object(plan, report)
        done = self._climb(plan, report)
        for setting in reversed(done[:-1]):
            self._hold(setting, "down", plan.dwell, report)
        middle, top = done[len(done) // 2], done[-1]
        self._hold(middle, "back", plan.dwell, report)
        fine = [middle + number * plan.fine for number in range(1, FINE_STEPS + 1)]
        for setting in fine:
            if setting <= top:
                self._hold(setting, "fine", plan.fine_dwell, report)
        return DriveRun(tuple(self._changes), self.now, np.array(self._time), np.array(self._force))

    def let_go(self) -> None:
        """Command the drive to open, for long enough that it receives it."""
        end = self._clock.now() + round(OPENING_S * NS)
        self._setting, self._due = 0.0, 0
        while self._clock.now() < end:
            self._serve()

    def _close_on_object(self, plan: SweepPlan, report: Report) -> None:
        report("waits for the pads")
        while any(math.isnan(force) for force in self._felt.values()):
            self._work()
        report("closes on the object")
        self._setting, self._due = plan.levels[0], 0
        end = self.now + CLOSING_S
        while not all(force > TOUCH_N for force in self._felt.values()):
            if self.now > end:
                felt = ", ".join(f"{name} {force:.2f} N" for name, force in self._felt.items())
                raise InputError(
                    f"the pads feel no object after {CLOSING_S:g} s ({felt}); put one between the jaws"
                )
            self._work()
        self._is_holding = True
        self._wait(plan.dwell)

    def _climb(self, plan: SweepPlan, report: Report) -> list[float]:
        """Go up as long as the next level will not be felt as more than is allowed; return the levels."""
        done, felt, slope = [0.0], [0.0], 0.0
        for setting in plan.levels:
            if felt[-1] + slope * (setting - done[-1]) > plan.most:
                break
            self._hold(setting, "up", plan.dwell, report)
            done.append(setting)
            felt.append(float(np.median(self._force[-8:])))
            slope = (felt[-1] - felt[-2]) / (done[-1] - done[-2])
        return done[1:]

    def _hold(self, setting: float, stage: Stage, seconds: float, report: Report) -> None:
        self._setting, self._due = setting, 0
        self._changes.append(Change(self.now, setting, stage))
        self._wait(seconds)
        report(f"{stage} {setting:.1f} N, felt {self._force[-1]:.1f} N")

    def _wait(self, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end:
            self._work()

    def _work(self) -> None:
        self._serve()
        self._check()

    def _serve(self) -> None:
        """Take what came, renew the command, and wait a little."""
        now = self._clock.now()
        if now >= self._due:
            self._due = now + round(RENEWED_S * NS)
            self._seq += 1
            for finger in self._fingers:
                expires = now + round(LIFETIME_S * NS)
                values = (now, finger, self._seq, self._setting, 0.0, Reason.HOLD, expires)
                self._drive.send(make_row(ForceCommand, values))
        for pad, names in self._pads:
            for message, arrival in zip(pad.receive(0.0), pad.arrivals, strict=True):
                if isinstance(message, FingertipState) and message.finger in names:
                    self._note(names[message.finger], message.normal_force, arrival)
        if all(self._drive is not pad for pad, _ in self._pads):
            self._drive.receive(0.0)
        self._clock.sleep_until(now + round(NAP_S * NS))

    def _note(self, finger: str, force: float, arrival: int) -> None:
        if math.isnan(force):
            return
        self._felt[finger], self._received[finger] = force, arrival
        if self._balance is not None and self._is_holding:
            self._is_even = not self._balance.note(finger, force, arrival)
        mean = sum(self._felt.values()) / len(self._felt)
        if not math.isnan(mean):
            self._time.append(arrival / NS)
            self._force.append(mean)

    def _check(self) -> None:
        now = self._clock.now()
        for finger, received in self._received.items():
            if now - received > SILENT_S * NS:
                raise DeviceError(
                    f"the pad of {finger} is silent, so the jaws are opened; `vegrip doctor` tries it"
                )
        if times_lost(self._drive) > self._lost:
            raise DeviceError("the drive does not answer; what it does then is in docs/drives.md")
        if self._drive.rejected.get("not_ready"):
            raise DeviceError(f"the force cannot change: {self._drive.hints['not_ready']}")
        if said := sorted(name for _, name in self._drive.device_faults - self._known):
            what = "the jaws are opened" if self._drive.obeys else "it takes no command, and its jaws stay"
            raise DeviceError(f"the drive says of itself: {', '.join(said)}; {what}")
        if above := [force for force in self._felt.values() if force > OVER * self.most]:
            raise InputError(
                f"{max(above):.1f} N are felt and {self.most:g} N allowed, so the jaws are opened; is "
                "the unit of the drive's or the pads' map right?"
            )
        if not self._is_even and self._balance is not None:
            felt = " and ".join(f"{name} {force:.1f} N" for name, force in self._balance.means.items())
            raise InputError(
                f"{felt} are felt, unlike by more than noise and gains allow, so the jaws are opened: look "
                "at unit, scale and zero of the pads, and at what touches one of them"
            )
