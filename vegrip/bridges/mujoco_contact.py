"""The contact of MuJoCo that comes nearest to a fitted model, and in numbers what it cannot represent.

MuJoCo's contact at rest is the soft constraint of its manual ("Computation", "Constraint model"; "Solver
parameters"), with penetration ``r`` [m], impedance ``d(r)`` of ``solimp``, ``solref = (-S, -B)`` and ``m``
[kg] the effective mass of the two bodies along the normal::

    N(r) = m S r d(r)^2 / ((1 - d(r)) d_max^2)                                   what it presses
    v    = f_t (1 - d(r)) d_max / (m d(r) B impratio)                            how fast it creeps
    |f_t / mu|^2 + |tau / mu_t|^2 <= N^2                                         when it slides

It is a spring of one shape without memory, and friction gives way at any tangential force ``f_t`` [N]: a
held object creeps by ``v`` [m/s] unless ``noslip_iterations`` is set (mujoco#3328).
"""

import math
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from scipy.optimize import least_squares

from vegrip.contact.limit_surface import queries
from vegrip.contact.limit_surface.fast import torsion_limit
from vegrip.errors import ModelError
from vegrip.model import ContactModel
from vegrip.types import Floats

PRESSED_S: Final = 0.01  # [s] in which a depth is reached
LONG_S: Final = 10.0  # [s] of the hold at whose end the lost force is stated
DEPTHS: Final = 16  # between a tenth of the largest and the largest
RATIO: Final = 1.2  # largest depth over the model's reference depth, where no recording states one
LOW: Final = (math.log(1e-2), 1e-3, 0.3, 0.1, 1.0)
HIGH: Final = (math.log(1e9), 0.98, 0.99, 0.9, 4.0)
"""Bounds of the search: ln S, impedance at touch, impedance at depth, midpoint, power (1 at least)."""


@dataclass(frozen=True)
class MujocoContact:
    """Attributes of a ``geom`` with ``condim="4"`` and a ``priority`` above the object's."""

    solref: tuple[float, float]  # -S [1/s^2], -B [1/s]
    solimp: tuple[float, float, float, float, float]  # d_min, d_max [1], width [m], midpoint, power [1]
    friction: tuple[float, float, float]  # mu [1], mu_t [m], rolling [m]
    mass: float  # [kg] effective, for which it holds

    def impedance(self, depth: Floats) -> Floats:
        """Return d(r) [1] at ``depth`` [m]."""
        return impedance(self.solimp, depth)

    def force(self, depth: Floats) -> Floats:
        """Return the normal force [N] at rest."""
        d = self.impedance(depth)
        pressed: Floats = self.mass * -self.solref[0] * depth * d**2 / ((1.0 - d) * self.solimp[1] ** 2)
        return pressed

    def creep(self, tangential: float, depth: float, impratio: float) -> float:
        """Return the speed [m/s] of a held contact without noslip, under ``tangential`` [N]."""
        d = float(self.impedance(np.array([depth]))[0])
        return tangential * (1.0 - d) * self.solimp[1] / (self.mass * d * -self.solref[1] * impratio)


def impedance(solimp: tuple[float, ...], depth: Floats) -> Floats:
    """Return MuJoCo's d(r): from the first to the second of ``solimp`` over its width, as a smooth step."""
    low, high, width, middle, power = solimp
    x = np.clip(np.asarray(depth, dtype=np.float64) / width, 0.0, 1.0)
    up, down = middle ** (1.0 - power), (1.0 - middle) ** (1.0 - power)
    y = np.where(x <= middle, up * x**power, 1.0 - down * (1.0 - x) ** power)
    d: Floats = low + (high - low) * y
    return d


@dataclass(frozen=True)
class Misfit:
    """What the nearest contact cannot represent, over the depths it was fitted to."""

    deepest: float  # [m]
    force_range: tuple[float, float]  # [N]
    force_error: float  # [1] largest, of the force after the hold
    force_lost: float  # [1] share of the force that relaxes from the press to 10 s; MuJoCo loses none
    friction_change: float  # [1] of mu over the range of force; MuJoCo has one
    torsion_error: float  # [1] largest, of the torque that slides; MuJoCo's grows as N, a fingertip's as N a
    surface_error: float  # [1] largest share by which the ellipse holds more than the limit surface
    creep_half_load: float  # [m/s] at half the sliding load, largest force, impratio 10, without noslip

    def sentences(self) -> list[str]:
        low, high = self.force_range
        return [
            f"fitted from {low:.2g} to {high:.2g} N, to a depth of {1e3 * self.deepest:.2g} mm:"
            f" the force is off by {100 * self.force_error:.1f} % at most",
            f"relaxation: the fingertip loses {100 * self.force_lost:.0f} % of its force in {LONG_S:g} s,"
            " MuJoCo none",
            f"friction changes by {100 * self.friction_change:.0f} % over these forces, MuJoCo's does not",
            f"torsion: the torque that slides is off by {100 * self.torsion_error:.0f} % at most",
            f"limit surface: MuJoCo's ellipse holds up to {100 * self.surface_error:.1f} % more",
            f"creep without noslip, at half the sliding load and impratio 10:"
            f" {1e3 * self.creep_half_load:.2g} mm/s; set noslip_iterations",
        ]


@dataclass(frozen=True)
class NearestContact:
    """A contact and its misfit; ``str`` is the part of an MJCF file."""

    contact: MujocoContact
    misfit: Misfit

    def to_json(self) -> dict[str, Any]:
        return {**asdict(self.contact), "cannot": asdict(self.misfit)}

    def __str__(self) -> str:
        one = self.contact
        rows = {"solref": one.solref, "solimp": one.solimp, "friction": one.friction}
        attributes = " ".join(f'{name}="{" ".join(f"{v:.6g}" for v in row)}"' for name, row in rows.items())
        said = "\n".join(f"  {line}" for line in self.misfit.sentences())
        return (
            f"<mujoco>\n<!-- for an effective mass of {one.mass:g} kg: another mass, another force\n{said}\n"
            "-->\n"
            '<option cone="elliptic" impratio="10" noslip_iterations="10"/>\n'
            f'<default><default class="fingertip"><geom condim="4" priority="1" {attributes}/>'
            "</default></default>\n</mujoco>\n"
        )


def nearest_contact(model: ContactModel, mass: float, hold: float = 1.0) -> NearestContact:
    """Return MuJoCo's contact whose force is nearest to that of ``model`` after ``hold`` [s].

    ``mass`` [kg] is the effective one of fingertip and object along the normal: 1/m = 1/m_tip + 1/m_object.

    Raises:
        ModelError: the model does not press over the depths it was seen at.

    """
    deepest = model.shown.depth if math.isfinite(model.shown.depth) else RATIO * model.reference_depth
    depths = deepest * np.geomspace(0.1, 1.0, DEPTHS)
    pressed, held, late, radius, k, mu = np.array(
        [_course(model, depth, hold) for depth in depths.tolist()]
    ).T
    if not (np.isfinite(held).all() and (held > 0.0).all() and (late > 0.0).all()):
        raise ModelError(f"the model presses with no force at some depths up to {deepest:.3g} m")

    contact = nearest_law(depths, held, mass, _friction(radius, k, mu, held))
    limit = float(mu[-1] * held[-1])
    return NearestContact(
        contact,
        Misfit(
            deepest=float(deepest),
            force_range=(float(held[0]), float(held[-1])),
            force_error=float(np.abs(contact.force(depths) / held - 1.0).max()),
            force_lost=float((1.0 - late / pressed).max()),
            friction_change=float(mu.max() / mu.min() - 1.0),
            torsion_error=float(
                np.abs(contact.friction[1] * held / _torques(radius, k, mu, held) - 1.0).max()
            ),
            surface_error=_surface_error(float(np.median(k))),
            creep_half_load=contact.creep(0.5 * limit, float(deepest), 10.0),
        ),
    )


def nearest_law(
    depths: Floats, forces: Floats, mass: float, friction: tuple[float, float, float]
) -> MujocoContact:
    """Return the contact whose force at rest is nearest to ``forces`` [N] at ``depths`` [m], in ln N."""
    deepest = float(depths.max())

    def contact_at(x: Floats) -> MujocoContact:
        log_stiffness, low, high, middle, power = x.tolist()
        stiffness = math.exp(log_stiffness)  # and critically damped
        solimp = (low, max(high, low), deepest, middle, power)
        return MujocoContact((-stiffness, -2.0 * math.sqrt(stiffness)), solimp, friction, mass)

    def residuals(x: Floats) -> Floats:
        errors: Floats = np.log(contact_at(x).force(depths) / forces)
        return errors

    guess = math.log(float(forces.max()) / (mass * deepest))
    starts = [(guess, low, 0.9, 0.5, power) for low in (0.1, 0.5) for power in (1.0, 2.0)]
    inside = [np.clip(start, np.array(LOW) + 1e-6, np.array(HIGH) - 1e-6) for start in starts]
    found = [least_squares(residuals, start, bounds=(LOW, HIGH)) for start in inside]
    return contact_at(min(found, key=lambda one: float(one.cost)).x)


def _course(model: ContactModel, depth: float, hold: float) -> tuple[float, ...]:
    """Return force [N] when pressed, after ``hold`` [s] and late; radius [m], exponent, mu after ``hold``."""
    t = np.concatenate([[0.0], np.geomspace(PRESSED_S, PRESSED_S + max(LONG_S, hold), 200)])
    at = int(np.searchsorted(t, PRESSED_S + hold, side="right")) - 1
    run = model.simulate(t, np.minimum(t / PRESSED_S, 1.0) * depth)
    force = run.normal_force
    last = (run.contact_radius[at], run.pressure_exponent[at], run.friction_coefficient[at])
    return float(force[1]), float(force[at]), float(force[-1]), *map(float, last)


def _torques(radius: Floats, k: Floats, mu: Floats, force: Floats) -> Floats:
    """Return the torques [N m] at which the contacts of these forces slide."""
    limits = np.array([torsion_limit(one) for one in k.tolist()])
    torques: Floats = mu * force * radius * limits
    return torques


def _friction(radius: Floats, k: Floats, mu: Floats, force: Floats) -> tuple[float, float, float]:
    """Return mu [1], mu_t [m] and no rolling friction: the geometric means over the forces."""
    torsion = _torques(radius, k, mu, force) / force
    return float(np.exp(np.log(mu).mean())), float(np.exp(np.log(torsion).mean())), 1e-4


def _surface_error(k: float) -> float:
    """Return the largest share by which an ellipse with the same ends lies outside the limit surface."""
    angle = np.linspace(0.0, 0.5 * math.pi, 91)
    gauge = queries.gauge(k, np.cos(angle), torsion_limit(k) * np.sin(angle))
    return float(gauge.max() - 1.0)
