"""The virtual hand step by step in numpy: what the compiled steps are compared with."""

import math

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import VirtualHand, kernels
from vegrip.virtual.disturbance import NO_BURDEN, Burden, total
from vegrip.virtual.plate import COURANT
from vegrip.virtual.slips import DISTANCE, SEPARATING_REST_S, is_sliding


class SteppedHand(VirtualHand):
    """The same hand, its mechanics by arrays and one step at a time."""

    def _steps_at_once(self) -> int:
        return 1

    def _advance(self, steps: int, commands: Floats) -> None:
        assert steps == 1
        s, soft = self.settings, self.soft
        dt = s.step
        self._ticks += 1
        if s.thermal.warming and (material := self._warming.material(self.time)) is not None:
            soft.heat(*material)
        self._move(self._wanted(commands), soft.force[1:], self._chain_stiffness())
        soft.press(self._indentation())
        self._a, self._k = soft.contact_radius, soft.pressure_exponent
        burden = total(self.events, self.time) if self.events else NO_BURDEN
        self._mu = burden.friction * self._friction
        if not self.dropped:
            self._carry(burden, dt)
            plate = self.plate
            self._counter.sliding[:] = is_sliding(plate.slip[:, 0], plate.slip[:, 1], self._a)
            self._count(self._counter.sliding > 0.0, plate.slip[:, 1], dt)
            if plate.lost:
                self._state[1] = 1.0
                self._counter.sliding[:] = 0.0
                plate.wrench[:] = 0.0
                plate.slip[:, :2] = 0.0

    def _move(self, wanted: Floats, force: Floats, stiffness: Floats) -> None:
        s, drives, dt = self.settings.actuator, self._drives, self.settings.step
        start = np.where(np.isnan(drives.target), force, drives.target)
        change = within(s.force_rate * dt, within(s.force_limit, wanted, 0.0) - start)
        drives.target[:] = start + change
        error = drives.target - force
        pull = error - within(s.stiction, error)
        speed = within(s.speed, 2.0 * math.pi * s.bandwidth * pull / stiffness)
        drives.position += dt * np.where(np.isnan(speed), 0.0, speed)

    def _wanted(self, commands: Floats) -> Floats:
        s = self.settings.actuator
        if self.dropped:
            return np.full(len(commands) - 1, np.nan)
        if self.time <= s.close_time:
            return np.full(len(commands) - 1, s.initial_force)
        first, others = float(commands[0]), commands[1:]
        asked = float(np.nansum(others))
        if not first > asked:  # NaN included
            return others
        if asked > 0.0:
            return others * (first / asked)
        return np.where(np.isnan(others), np.nan, first / max(1, int(np.sum(~np.isnan(others)))))

    def _stand(self) -> float:
        s = self.settings.actuator
        gone = (self.time - s.close_time) / s.lift_time if s.lift_time > 0.0 else self.time - s.close_time
        return float(np.clip(1.0 - gone, 0.0, 1.0)) if s.lift_time > 0.0 else float(gone <= 0.0)

    def _chain_stiffness(self) -> Floats:
        soft = self.soft
        depth = np.maximum(soft.indentation, 0.05 * soft.d0)
        own = soft.instant * soft.p * soft.elastic_force(depth) / depth
        chain: Floats = 1.0 / (1.0 / own[1:] + (len(own) - 1) / own[0])
        return chain

    def _indentation(self) -> Floats:
        soft = self.soft
        if self.dropped:
            return -soft.d0
        x = np.concatenate([[0.0], self._drives.position])
        self._state[0] = kernels.balance(
            x, self._side, soft.past, soft.instant, soft.before, soft.F0, soft.d0, soft.p, self._state[0]
        )
        depth: Floats = x + self._side * self._state[0]
        return depth

    def _carry(self, burden: Burden, dt: float) -> None:
        plate, s, grid, a = self.plate, self.settings.plate, self._grid, self._a
        mass = s.mass + burden.mass
        weight = (1.0 - self._stand()) * mass * s.gravity
        force_x = burden.force_x + weight * math.sin(burden.turn)
        force_y = burden.force_y - weight * math.cos(burden.turn)
        stiffness = plate.stiffness * math.pi * a**2
        lever = plate.place - plate.pose[:2]
        turning = stiffness * (np.vecdot(lever, lever) + 0.5 * a**2) / s.inertia
        pushing = stiffness / mass
        square = float(max(pushing.sum(), turning.sum()))
        viscous = float(max(pushing @ plate.damping, turning @ plate.damping))
        substeps = max(1, math.ceil(dt * max(math.sqrt(square), viscous) / COURANT))
        kernels.carry(
            plate.pose, plate.bristle, plate.wrench, plate.slip,
            grid.load(self._k), grid.area, grid.reach, grid.cosine, grid.sine,
            a, self.soft.force, self._mu, plate.stiffness, plate.damping, plate.place,
            mass, s.inertia, np.array([force_x, force_y, burden.torque]), substeps, dt / substeps,
        )  # fmt: skip

    def _count(self, whole: Floats, speed: Floats, dt: float) -> None:
        event, slid = self._counter.event, self._counter.slid
        if whole.any():
            if not event[1]:
                event[1:3], slid[:] = (1.0, 0.0), 0.0
            event[3] = 0.0
            slid += np.where(whole, speed * dt, 0.0)
            if not event[2] and slid.max() > DISTANCE:
                event[2], event[0] = 1.0, event[0] + 1.0
        elif event[1]:
            event[3] += dt
            event[1] = event[3] < SEPARATING_REST_S


def within(limit: float, values: Floats, low: float | None = None) -> Floats:
    """Return ``values`` held between -limit (or ``low``) and limit; NaN stays NaN."""
    held: Floats = np.minimum(np.maximum(values, -limit if low is None else low), limit)
    return held
