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
from vegrip.virtual.disturbance import Burden, Disturbance, burden_rows, total
from vegrip.virtual.drive import Drives
from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.patch import even_grid
from vegrip.virtual.plate import Plate
from vegrip.virtual.profile import FIRST, RATIO, coefficient_logarithms, ring_shares
from vegrip.virtual.sensor import Sensors
from vegrip.virtual.settings import HandSettings
from vegrip.virtual.slips import CONSTANTS, SlipCounter
from vegrip.virtual.thermal import Warming

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
        self.tips = s.tips(make)
        self.soft = Fingertips(self.tips, s.step)
        n = len(self.tips)
        self._side = np.where(np.arange(n) == 0, 1.0, -1.0)  # an opposed finger is relieved when z grows
        self._turned = np.where(self._side[:, None] > 0.0, [-1.0, 1.0, -1.0], [1.0, 1.0, 1.0])
        self._drives = Drives(s.actuator, n - 1)
        self._drives.position[:] = -CLEARANCE_M
        self._grid = even_grid(s.rings, s.spokes)
        self.plate = Plate(s.plate, self.tips, np.column_stack([s.x, s.y]), self._grid)
        self._sensors = Sensors(s.sensor, s.fingers, noise)
        self._warming = Warming(s.thermal)
        self._counter = SlipCounter(n)
        self._friction = np.array([tip.friction for tip in self.tips])
        self._mu = self._friction.copy()
        self._a, self._k = self.soft.contact_radius, self.soft.pressure_exponent
        self._state = np.zeros(2)  # place of the object along the normals [m], 1 when it was dropped
        self._closing = np.array([s.actuator.initial_force, s.actuator.close_time, s.actuator.lift_time])
        self._tables = coefficient_logarithms(), ring_shares(self._grid.edges), FIRST, RATIO
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
        """Number of distinct slips so far."""
        return self._counter.count

    @property
    def largest_micro_slip(self) -> float:
        """The longest slide of a whole patch that is too short to count as a slip [m]."""
        return self._counter.largest_micro_slip

    @property
    def dropped(self) -> bool:
        """Whether the object was lost."""
        return bool(self._state[1] > 0.0)

    @property
    def burden(self) -> Burden:
        """What acts on the object now besides its own weight."""
        return total(self.events, self.time)

    def step(self, dt: float, forces: Mapping[str, float]) -> list[FingertipState]:
        """Advance by ``dt`` [s] under the normal forces commanded [N]; return the states sampled on the way.

        A finger that is not in ``forces`` has no valid command and holds its position.

        Raises:
            UsageError: a force for a finger that the hand does not have.

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
        """Return true normal force [N], friction, contact radius [m] and exponent of a finger."""
        of = (self.soft.force, self._mu, self._a, self._k)
        force, mu, radius, exponent = (float(values[number]) for values in of)
        return force, mu, radius, exponent

    def truths(self) -> Floats:
        """Return what is really the case at all contacts, in the order of :data:`TRUTHS`; (n, 14)."""
        plate, grid = self.plate, self._grid
        return kernels.true_contacts(
            self.soft.force, plate.wrench, self._turned, self.soft.indentation, self._a, self._k, self._mu,
            plate.slip, self._counter.sliding, grid.reach, grid.cosine, grid.sine, *self._tables[1:],
        )  # fmt: skip

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
        """Whether the next sample is taken after step number ``tick``."""
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
        """Take ``steps`` steps of the mechanics."""
        if self.settings.thermal.warming:
            self._warm((self._ticks + 1) * self.settings.step)
        soft, drives, plate, grid, counter = self.soft, self._drives, self.plate, self._grid, self._counter
        past = soft.history
        kernels.hand_ticks(
            steps, self._ticks, self.settings.step, self._closing, commands, self._acting(steps), self._state,
            self._side, soft.radius, soft.d0, soft.p, soft.F0, self._friction,
            soft.indentation, soft.force, soft.before, soft.reference, self._mu, self._a, self._k,
            drives.position, drives.target, drives.limits,
            past.recent, past.reversed_weights, past.instant, past.older, past.newer, past.filled,
            past.fine, past.block,
            plate.pose, plate.start, plate.bristle, plate.wrench, plate.slip, plate.place,
            plate.stiffness, plate.damping, plate.laws,
            counter.sliding, counter.slid, counter.event, CONSTANTS,
            grid.area, grid.reach, grid.cosine, grid.sine, *self._tables, soft.fresh_coefficient,
        )  # fmt: skip
        past.grow(steps)
        self._ticks += steps

    def _warm(self, time: float) -> None:
        material = self._warming.material(time)
        if material is not None:
            self.soft.heat(*material)

    def _sense(self) -> HandSample:
        return self._sensors.sample_tips(
            self.soft.force, self.plate.wrench, self._turned, self.soft.indentation,
            self._warming.temperature(self.time), self.plate.slip, self._a, self._counter.sliding,
            self.time, self.epoch,
        )  # fmt: skip
