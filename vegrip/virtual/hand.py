"""The virtual hand: soft fingertips that hold a plate, in simulated time, seeded and repeatable.

The first finger opposes the others and holds its place; the others are force-controlled. The plate finds the
place between the faces at which the normal forces cancel, and hangs on friction alone. Contact frames are
right-handed with z the outward normal of the fingertip: those of the opposed fingers are parallel to the
hand's frame, that of the first finger is turned by half a turn about y. Tangential force and torque are what
the object does to the fingertip.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from vegrip.errors import UsageError
from vegrip.hand_sample import HandSample
from vegrip.messages import FingertipState
from vegrip.types import Floats
from vegrip.virtual import kernels
from vegrip.virtual.disturbance import Disturbance, burden_rows
from vegrip.virtual.fingertip import Fingertips, Warming, even_grid
from vegrip.virtual.profile import coefficient_logarithms, ring_shares
from vegrip.virtual.sensor import Sensors
from vegrip.virtual.settings import HandSettings

CLEARANCE_M = 2e-4
"""Distance of the opposed fingers from the object at the start [m]."""

CHUNK = 64
"""Steps of the mechanics that are taken at once, at most."""


@dataclass(frozen=True, slots=True)
class FingerTruth:
    """What is really the case at one contact."""

    normal_force: float  # [N]
    indentation: float  # [m], negative out of contact
    contact_radius: float  # [m]
    pressure_exponent: float  # [-]
    friction_coefficient: float  # [-]
    tangential_force_x: float  # [N] in the contact frame
    tangential_force_y: float  # [N]
    torque_z: float  # [N m]
    utilisation: float  # [-] |load| / limit_radius, 1 = on the limit surface, inf = loaded without contact
    limit_radius: float  # [N] along the present load, torque divided by the contact radius
    sliding: bool  # the whole patch slides
    sliding_share: float  # [-] slip speed over the speed of the object over the patch
    slip_speed: float  # [m/s]
    slip_distance: float  # [m] slid since the start

    @property
    def margin(self) -> float:
        """Slip margin [-]: one without load, zero on the limit surface."""
        return 1.0 - self.utilisation


TRUTHS = tuple(field.name for field in fields(FingerTruth))
SLIDING = TRUTHS.index("sliding")


class VirtualHand:
    """A hand in simulated time.

    Args:
        settings: what the hand is made of.
        seed: of the scatter between fingertips, of bias and noise; same seed, same hand, bit for bit.
        events: disturbances, see :func:`vegrip.virtual.disturbance.disturbances`.

    """

    def __init__(
        self, settings: HandSettings | None = None, seed: int = 0, events: Sequence[Disturbance] = ()
    ) -> None:
        self.settings = s = settings if settings is not None else HandSettings()
        self.fingers, self.events = s.fingers, tuple(events)
        self._names = frozenset(s.fingers)
        make, noise = (np.random.default_rng([seed, stream]) for stream in (0, 1))
        self.soft = Fingertips(s.tips(make), s.step)
        self._grid = even_grid(s.rings, s.spokes)
        self._sensors = Sensors(s.sensor, s.fingers, noise)
        self._warming = Warming(s.thermal)
        self.tips = tips = self.soft.records
        """Of the tips, by the names of :class:`vegrip.virtual.kernels.Tip`."""
        tips["x"], tips["y"], tips["side"] = s.x, s.y, -1.0
        tips["side"][0] = 1.0  # an opposed finger is relieved when z grows
        tips["position"][1:], tips["target"] = -CLEARANCE_M, np.nan
        kernels.find_exponents(tips, coefficient_logarithms())
        self.body = np.zeros(1, kernels.BODY)
        """What the fingers share, by the names of :class:`vegrip.virtual.kernels.Body`."""
        self.body["step"] = s.step
        for part in (s.actuator, s.plate):
            for name in kernels.Body.__annotations__.keys() & vars(part).keys():
                self.body[name] = getattr(part, name)
        self.body["x"] = self.body["start_x"] = s.plate.offset_x
        self.body["y"] = self.body["start_y"] = s.plate.offset_y
        self._state = kernels.Hand(
            self.body, self._grid.contacts(tips), self.soft.history.memory, coefficient_logarithms(),
            ring_shares(self._grid.edges),
        )  # fmt: skip
        self._burdens, self._burdens_from = np.zeros((0, 6)), 0  # of the steps from that number on
        self._ticks = 0
        self.asked = 0.0  # [s] simulated time asked for
        self._samples = 0
        self.epoch = 0  # [ns] stamp of simulated time zero

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._ticks * self.settings.step

    @property
    def slips(self) -> int:
        return int(self.body["slips"][0])

    @property
    def largest_micro_slip(self) -> float:
        """The longest slide of a whole patch that was too short to count as a slip [m]."""
        ended = self.body.copy()
        kernels.end_event(ended[0], self.tips)
        return float(ended["largest_micro_slip"][0])

    @property
    def dropped(self) -> bool:
        return bool(self.body["dropped"][0] > 0.0)

    @property
    def shift(self) -> Floats:
        """How far the object has moved from where it was grasped: x, y [m], angle [rad]."""
        b = self.body
        return np.concatenate([b["x"] - b["start_x"], b["y"] - b["start_y"], b["angle"]])

    def step(self, dt: float, forces: Mapping[str, float]) -> list[FingertipState]:
        """Advance by ``dt`` [s] under the normal forces commanded [N]; return the states sampled on the way.

        A finger that is not in ``forces`` has no valid command and holds its position.
        """
        if not forces.keys() <= self._names:
            raise UsageError(f"the hand has no finger {', '.join(forces.keys() - self._names)}")
        commands = np.array([forces.get(finger, np.nan) for finger in self.fingers])
        return [state for sample in self.advance(dt, commands) for state in sample.states(self.fingers)]

    def advance(self, dt: float, commands: Floats) -> list[HandSample]:
        """Advance by ``dt`` [s] under the normal forces commanded of all fingers [N], NaN = none.

        As :meth:`step`; returns the samples taken on the way.
        """
        samples: list[HandSample] = []
        self.asked += dt
        while (self._ticks + 0.5) * self.settings.step < self.asked:
            self._advance(self._steps_at_once(), commands)
            if self._is_sampled(self._ticks):
                self._samples += 1
                samples.append(self._sense())
        return samples

    def truth(self, finger: str) -> FingerTruth:
        """Return what is really the case at the contact of ``finger``."""
        row = self.truths()[self.fingers.index(finger)].tolist()
        row[SLIDING] = row[SLIDING] > 0.0
        return FingerTruth(*row)

    def contact(self, number: int) -> tuple[float, float, float, float]:
        """Return true normal force [N], friction at it, contact radius [m] and exponent of a finger."""
        tip = self.tips[number]
        return float(tip["force"]), float(tip["mu"]), float(tip["a"]), float(tip["k"])

    @property
    def friction_exponent(self) -> float:
        """By which friction falls with the normal force [-], see :class:`.settings.FingertipSettings`."""
        return self.settings.tip.friction_exponent

    def truths(self) -> Floats:
        """Return what is really the case at all contacts, in the order of :data:`TRUTHS`; (n, 14)."""
        return kernels.true_contacts(self._state.contacts, self._state.shares)

    def _steps_at_once(self) -> int:
        """Return how many steps to take before something other than mechanics is due: one at least."""
        step, steps = self.settings.step, 1
        most = 1 if self.settings.thermal.warming else min(CHUNK, self.soft.history.room)
        while steps < most and (self._ticks + steps + 0.5) * step < self.asked:
            if self._is_sampled(self._ticks + steps):
                break
            steps += 1
        return steps

    def _is_sampled(self, tick: int) -> bool:
        return tick * self.settings.step * self.settings.sensor.rate >= self._samples + 1.0 - 1e-9

    def _acting(self, steps: int) -> Floats:
        """Return what acts on the object in the coming steps, see :func:`~.disturbance.burden_rows`."""
        first = self._ticks + 1
        ahead = first - self._burdens_from
        if not 0 <= ahead <= len(self._burdens) - steps:
            times = np.arange(first, first + CHUNK, dtype=np.float64) * np.float64(self.settings.step)
            self._burdens, self._burdens_from = burden_rows(self.events, times), first
            ahead = 0
        return self._burdens[ahead : ahead + steps]

    def _advance(self, steps: int, commands: Floats) -> None:
        if self.settings.thermal.warming:
            self._warm((self._ticks + 1) * self.settings.step)
        past, step = self.soft.history, self._ticks
        kernels.advance(self._state, step, steps, past.filled, commands, self._acting(steps))
        past.grow(steps)
        self._ticks += steps

    def _warm(self, time: float) -> None:
        material = self._warming.material(time)
        if material is not None:
            self.soft.heat(*material)

    def _sense(self) -> HandSample:
        warmth = self._warming.temperature(self.time)
        return self._sensors.sample(self.tips, warmth, self.time, self.epoch)
