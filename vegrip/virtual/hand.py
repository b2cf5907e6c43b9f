"""The virtual hand: soft fingertips that hold a plate, in simulated time, seeded and repeatable.

The first finger opposes the others and holds its place; the others are force-controlled. The plate finds the
place between the faces at which the normal forces cancel, and hangs on friction alone. Contact frames are
right-handed with z the outward normal of the fingertip: those of the opposed fingers are parallel to the
hand's frame, that of the first finger is turned by half a turn about y. Tangential force and torque are what
the object does to the fingertip.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vegrip.errors import UsageError
from vegrip.messages import FingertipState
from vegrip.virtual import kernels
from vegrip.virtual.disturbance import NOTHING, Burden, Disturbance, total
from vegrip.virtual.drive import Drives, share
from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.patch import even_grid, utilisation
from vegrip.virtual.plate import Plate
from vegrip.virtual.sensor import CHANNELS, Reading, Sensors
from vegrip.virtual.settings import HandSettings
from vegrip.virtual.slips import SlipCounter, is_sliding
from vegrip.virtual.thermal import Warming

Array = npt.NDArray[np.float64]

CLEARANCE = 2e-4
"""Distance of the opposed fingers from the object at the start [m]."""


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
        make, noise = (np.random.default_rng([seed, stream]) for stream in (0, 1))
        self.tips = s.tips(make)
        self.soft = Fingertips(self.tips, s.step)
        n = len(self.tips)
        self._side = np.where(np.arange(n) == 0, 1.0, -1.0)  # an opposed finger is relieved when z grows
        self._drives = Drives(s.actuator, n - 1)
        self._drives.position[:] = -CLEARANCE
        self._grid = even_grid(s.rings, s.spokes)
        self.plate = Plate(s.plate, self.tips, np.column_stack([s.x, s.y]), self._grid)
        self._sensors = Sensors(s.sensor, s.fingers, noise)
        self._warming = Warming(s.thermal)
        self._counter = SlipCounter()
        self._friction = np.array([tip.friction for tip in self.tips])
        self._mu = self._friction
        self._z = 0.0
        self._sliding = np.zeros(n, bool)
        self._ticks = 0
        self.asked = 0.0  # [s] simulated time asked for
        self._samples = 0
        self.dropped = False
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
    def burden(self) -> Burden:
        """What acts on the object now besides its own weight."""
        return total(self.events, self.time)

    def step(self, dt: float, forces: Mapping[str, float]) -> list[FingertipState]:
        """Advance by ``dt`` [s] under the normal forces commanded [N]; return the states sampled on the way.

        A finger that is not in ``forces`` has no valid command and holds its position.

        Raises:
            UsageError: a force for a finger that the hand does not have.

        """
        if not forces.keys() <= set(self.fingers):
            raise UsageError(f"the hand has no finger {', '.join(forces.keys() - set(self.fingers))}")
        commands = np.array([forces.get(finger, np.nan) for finger in self.fingers])
        states: list[FingertipState] = []
        self.asked += dt
        while (self._ticks + 0.5) * self.settings.step < self.asked:
            self._tick(commands)
            if self.time * self.settings.sensor.rate >= self._samples + 1.0 - 1e-9:
                self._samples += 1
                states += self._sensors.measure(self._reading(), self.time, self.epoch)
        return states

    def truth(self, finger: str) -> FingerTruth:
        """Return what is really the case at the contact of ``finger``."""
        i = self.fingers.index(finger)
        N, a, mu = float(self.soft.force[i]), float(self.soft.contact_radius[i]), float(self._mu[i])
        k = float(self.soft.pressure_exponent[i])
        fx, fy, torque = self._contact_wrench()[i].tolist()
        f = float(np.hypot(fx, fy))
        used = utilisation(self._grid, k, f / (mu * N), torque / (mu * N * a)) if N > 0.0 and a > 0.0 else 0.0
        load = float(np.hypot(f, torque / a)) if a > 0.0 else 0.0
        share_sliding, speed, slid = self.plate.slip[i].tolist()
        return FingerTruth(
            normal_force=N,
            indentation=float(self.soft.indentation[i]),
            contact_radius=a,
            pressure_exponent=k,
            friction_coefficient=mu,
            tangential_force_x=fx,
            tangential_force_y=fy,
            torque_z=torque,
            utilisation=used,
            limit_radius=load / used if used > 0.0 else mu * N,
            sliding=bool(self._sliding[i]),
            sliding_share=share_sliding,
            slip_speed=speed,
            slip_distance=slid,
        )

    def _tick(self, commands: Array) -> None:
        dt = self.settings.step
        self._ticks += 1
        self._warm()
        self._drives.move(self._wanted(commands), self.soft.force[1:], self._chain_stiffness(), dt)
        self.soft.press(self._indentation())
        burden = total(self.events, self.time) if self.events else NOTHING
        self._mu = burden.friction * self._friction
        if not self.dropped:
            load = self._grid.load(self.soft.pressure_exponent)
            a, N = self.soft.contact_radius, self.soft.force
            self.plate.carry(a, N, load, self._mu, burden, self._stand(), dt)
            self._sliding = is_sliding(self.plate.slip[:, 0], self.plate.slip[:, 1], a)
            self._counter.watch(self._sliding, self.plate.slip[:, 1], dt)
            if self.plate.lost:
                self.dropped = True
                self._sliding = np.zeros_like(self._sliding)
                self.plate.wrench[:] = 0.0
                self.plate.slip[:, :2] = 0.0

    def _wanted(self, commands: Array) -> Array:
        """Forces of the opposed fingers: the hand's own grip while it closes, then what is commanded."""
        s = self.settings.actuator
        if self.dropped:
            return np.full(len(commands) - 1, np.nan)
        if self.time <= s.close_time:
            return np.full(len(commands) - 1, s.initial_force)
        return share(float(commands[0]), commands[1:])

    def _stand(self) -> float:
        """Share of gravity that the stand carries: all while the hand closes, then less and less."""
        s = self.settings.actuator
        gone = (self.time - s.close_time) / s.lift_time if s.lift_time > 0.0 else self.time - s.close_time
        return float(np.clip(1.0 - gone, 0.0, 1.0)) if s.lift_time > 0.0 else float(gone <= 0.0)

    def _chain_stiffness(self) -> Array:
        """Stiffness each drive works against when all move together: its tip and the first in series."""
        soft = self.soft
        depth = np.maximum(soft.indentation, 0.05 * soft.d0)
        own = soft.instant * soft.p * soft.elastic_force(depth) / depth
        chain: Array = 1.0 / (1.0 / own[1:] + (len(own) - 1) / own[0])
        return chain

    def _indentation(self) -> Array:
        soft = self.soft
        if self.dropped:
            return -soft.d0  # nothing is between the fingers any more
        x = np.concatenate([[0.0], self._drives.position])
        self._z = kernels.balance(
            x, self._side, soft.past, soft.instant, soft.before, soft.F0, soft.d0, soft.p, self._z
        )
        depth: Array = x + self._side * self._z
        return depth

    def _warm(self) -> None:
        material = self._warming.material(self.time) if self.settings.thermal.warming else None
        if material is not None:
            self.soft.heat(*material)

    def _contact_wrench(self) -> Array:
        """Force x, y [N] and torque z [N m] of the object on each fingertip, in its contact frame; (n, 3)."""
        turned = np.where(self._side[:, None] > 0.0, [-1.0, 1.0, -1.0], [1.0, 1.0, 1.0])
        wrench: Array = turned * self.plate.wrench
        return wrench

    def _reading(self) -> Reading:
        values = np.empty((len(self.fingers), len(CHANNELS)))
        values[:, 0] = self.soft.force
        values[:, 1:4] = self._contact_wrench()
        values[:, 4] = self.soft.indentation
        values[:, 5] = self._warming.temperature(self.time)
        values[:, 6] = self.plate.slip[:, 1]
        values[:, 7] = self.soft.contact_radius
        return Reading(values, self._sliding.astype(float))
