"""A test bench for one simulated fingertip: runs a protocol, returns what was measured and what was true."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import kernels
from vegrip.virtual.bench.protocol import Episode, Segment
from vegrip.virtual.fingertip import Fingertips, even_grid, utilisation
from vegrip.virtual.hidden import HIDDEN, Hidden, make
from vegrip.virtual.sensor import SENSED_CHANNELS, Sensors
from vegrip.virtual.settings import FingertipSettings, SensorSettings
from vegrip.virtual.specimen import Specimen, overridden

TRUTH = (
    "indentation",
    "normal_force",
    "contact_radius",
    "pressure_exponent",
    "friction_coefficient",
    "tangential_force",
    "torque_z",
    "utilisation",
)
"""Columns of the truth, SI."""
TIP = ("tip",)


@dataclass(frozen=True, eq=False)
class Trial:
    """One simulated recording.

    Attributes:
        columns: what was measured: ``t`` [s], ``episode`` and the channels of a recording, each (n,).
        truth: what was true at the same instants, by the names of :data:`TRUTH`, each (n,).
        tip: the first fingertip.
        noise: its sensors.

    """

    columns: dict[str, Floats]
    truth: dict[str, Floats]
    tip: FingertipSettings
    noise: SensorSettings


def run_trial(
    tip: FingertipSettings | Sequence[FingertipSettings],
    protocol: Sequence[Episode],
    noise: SensorSettings,
    seed: int = 0,
    *,
    temperature: float | Sequence[float] = 22.0,
    step: float = 1e-3,
    pause: float = 20.0,
    rings: int = 16,
    spokes: int = 32,
    truth: bool = True,
    hidden: Mapping[str, Mapping[str, float]] | None = None,
    catalogue: Mapping[str, type[Hidden]] = HIDDEN,
) -> Trial:
    """Put ``tip`` through ``protocol`` and measure it at ``noise.rate``.

    ``pause`` [s] lies between episodes and is not recorded; ``step`` [s] is that of the simulation. The same
    seed gives the same trial, bit for bit. ``temperature`` [degrees Celsius] may be one for each episode.
    ``hidden`` names effects that the plain fingertip does not have, with their parameters
    (of the ``catalogue``). Without ``truth`` that part is empty, and half of the time saved.
    ``tip`` may be one for each episode, where several places or specimens are pressed: each has been through
    what was done to it alone.
    Slip is measured without threshold and delay: the bench imposes the slide, so it need not feel it.
    """
    tips = [tip] * len(protocol) if isinstance(tip, FingertipSettings) else list(tip)
    benches = {one: _Bench(one, step, rings, spokes, make(hidden or {}, catalogue)) for one in set(tips)}
    at_once = replace(noise, slip_threshold=0.0, slip_delay=0.0)
    sensors = Sensors(at_once, TIP, np.random.default_rng(seed))
    every = max(1, round(1.0 / (noise.rate * step)))
    rows: list[tuple[float, ...]] = []
    truths: list[tuple[float, ...]] = []
    start = 0.0
    for number, episode in enumerate(protocol):
        warm = temperature if isinstance(temperature, float) else temperature[number]
        bench = benches[tips[number]]
        bench.reset(pause, warm)
        ticks = 0
        for ticks, segment in enumerate(_steps(bench, episode, step), 1):
            bench.slide(segment)
            if ticks % every == 0:
                true = bench.truth() if truth else ()
                for state in sensors.sample(bench.felt, warm, start + ticks * step).states(TIP):
                    measured = [getattr(state, channel) for channel in (*SENSED_CHANNELS, "slip")]
                    rows.append((state.stamp * 1e-9, number, *measured))
                    truths.append(true)
        start += ticks * step + pause
    columns = dict(zip(("t", "episode", *SENSED_CHANNELS, "slip"), np.array(rows).T, strict=True))
    present = {name: values for name, values in columns.items() if not np.all(np.isnan(values))}
    known = dict(zip(TRUTH, np.array(truths).T, strict=True)) if truth else {}
    return Trial(present, known, tips[0], noise)


def _steps(bench: "_Bench", episode: Episode, step: float) -> Iterator[Segment]:
    """Impose the normal motion of an episode step by step; yield the segment of each."""
    by_force = False
    for segment in episode:
        if segment.depth is not None or segment.force is not None:
            by_force = segment.force is not None
        begin = bench.force if by_force else bench.drive
        end = segment.force if by_force else segment.depth
        count = max(1, round(segment.duration / step))
        for part in np.arange(1, count + 1) / count:
            value = begin if end is None else begin + part * (end - begin)
            value += segment.amplitude * np.sin(2.0 * np.pi * segment.frequency * part * segment.duration)
            bench.impose(value, by_force=by_force)
            yield segment


class _Bench:
    """One fingertip against a moving counter-surface."""

    def __init__(
        self, tip: FingertipSettings, step: float, rings: int, spokes: int, hidden: tuple[Hidden, ...]
    ) -> None:
        self._step, self._hidden = step, hidden
        self._soft = Specimen(tip, step, hidden) if hidden else Fingertips([tip], step)
        self._grid = even_grid(rings, spokes)
        self._contacts = self._grid.contacts(self._soft.records.copy())
        self.felt = self._contacts.tips
        """What the counter-surface meets: the tip with all that is hidden."""
        self.felt["side"] = -1.0
        self._tip = self.felt[0]
        self._frictions, self._rubs = overridden(hidden, "friction"), overridden(hidden, "rubbed")
        self._senses = overridden(hidden, "sensed")

    def reset(self, pause: float, temperature: float) -> None:
        """Start an episode after ``pause`` [s]: recovered material, unbent bristles."""
        for one in self._hidden:
            one.start(pause)
            one.warmed(temperature)
        self._soft.reset()
        self.drive = 0.0  # [m] where it stands: the imposed indentation, before anything gives way
        self._contacts.bristles[:] = 0.0
        for name in ("pull_x", "pull_y", "torque", "sliding_share", "slip_speed"):
            self.felt[name] = 0.0
        self._bent = False

    @property
    def force(self) -> float:
        """Normal force [N]."""
        return float(self._soft.force[0])

    def impose(self, value: float, *, by_force: bool) -> None:
        """Impose a normal force [N] or an indentation [m] for one step."""
        if by_force:
            self.drive = float(self._soft.load(np.array([value]))[0])
        else:
            self.drive = value
            self._soft.press(np.array([value]))

    def slide(self, segment: Segment) -> None:
        """Move the counter-surface for one step."""
        soft, felt, force = self._soft, self._tip, self.force
        speed = float(felt["slip_speed"])
        felt["a"], felt["force"], felt["k"] = soft.contact_radius[0], force, soft.pressure_exponent[0]
        mu = kernels.friction_of(felt, 1.0)
        for friction in self._frictions:
            mu = friction(mu, force, speed)
        felt["mu"] = mu
        if segment.pull_x or segment.pull_y or segment.spin:
            self._bent = True
        if self._bent:
            self._contacts.load[:] = self._grid.load(self.felt["k"])
            kernels.rub(self._contacts, 0, segment.pull_x, segment.pull_y, segment.spin, self._step)
        felt["slides"] = kernels.slides_whole(felt)
        speed, pull, shown = float(felt["slip_speed"]), float(np.hypot(felt["pull_x"], felt["pull_y"])), force
        for rubbed in self._rubs:
            rubbed(force, speed, self._step)
        for sensed in self._senses:
            shown = sensed(shown, pull, self.drive, self._step)
        felt["force"], felt["depth"] = shown, self.drive  # as the sensors have them

    def truth(self) -> tuple[float, ...]:
        """Return the columns of :data:`TRUTH`."""
        tip = {name: float(self.felt[name][0]) for name in ("pull_x", "pull_y", "torque", "a", "k", "mu")}
        f, a, k, mu = math.hypot(tip["pull_x"], tip["pull_y"]), tip["a"], tip["k"], tip["mu"]
        limit = mu * self.force
        used = utilisation(self._grid, k, f / limit, tip["torque"] / (limit * a)) if limit * a else 0.0
        return float(self._soft.indentation[0]), self.force, a, k, mu, f, tip["torque"], used
