"""An object between a thumb and other fingers, of a make of its own: nothing here is taken from vegrip.

The object moves in the plane of its faces under a load F. Finger i presses with N_i and holds by one bristle
of stiffness kt_i, stretched by e_i, that slides where it would carry more than friction allows::

    m v' = F - sum_i T_i,    T_i = kt_i e_i + ct_i e_i',    |kt_i e_i| <= mu_i(N_i) N_i
    mu_i(N) = mu_i (N / 5 N)^-g

with ``kinetic * mu_i`` while it slides; g = 0 is Coulomb's law. Drives follow their commands with one pole
and a limit of rate. What thumb and others press differently is shared evenly: squeeze
S = (D_thumb + sum D_others) / 2, N_thumb = S, and the others' shares are as their drives'. Tips are
N = K (x / x_ref)^p - z, solved for x, with z' = nu (c K (x / x_ref)^p - z).
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

STEP = 2e-4  # [s] of the simulation
DEPTH_UNIT = 0.9e-3  # [m] x_ref
GRAVITY = 9.81  # [m/s^2]
STATED_AT_N = 5.0  # [N] at which friction is mu

OBJECT = 4  # x, y [m], their speeds [m/s]
DRIVE, RELAXED, BRISTLE_X, BRISTLE_Y, SLID_X, SLID_Y, PATH, FORCE, DEPTH, FORCE_X, FORCE_Y, SPEED, SLIDES = (
    range(13)
)
FINGER = 13  # numbers of state: [N], [N], [m], [m], [m], [m], [m], [N], [m], [N], [N], [m/s], 0 or 1
BANDWIDTH, RATE, STIFFNESS, DAMPING, TIP_FORCE, EXPONENT, SHARE, PACE = range(8)
CONSTANTS = 8  # of a finger: [Hz], [N/s], [N/m], [N s/m], [N], [-], [-], [1/s]


@njit(cache=True)
def advance(s, constants, mass, kinetic, g, command, mu_from, mu_to, load_from, load_to, steps):  # noqa: PLR0915
    """Go on by ``steps`` of STEP in place; mu and load go straight from one value to the other."""
    n = constants.shape[0]
    for i in range(n):
        at = OBJECT + i * FINGER
        s[at + FORCE_X] = s[at + FORCE_Y] = s[at + SPEED] = 0.0
    for step in range(steps):
        part = (step + 1.0) / steps
        others = 0.0
        for i in range(n):
            at = OBJECT + i * FINGER
            wish = 2.0 * math.pi * constants[i, BANDWIDTH] * (command[i] - s[at + DRIVE])
            wish = min(max(wish, -constants[i, RATE]), constants[i, RATE])
            s[at + DRIVE] = max(s[at + DRIVE] + wish * STEP, 0.0)
            if i > 0:
                others += s[at + DRIVE]
        squeeze = 0.5 * (s[OBJECT + DRIVE] + others)
        fx = load_from[0] + part * (load_to[0] - load_from[0])
        fy = load_from[1] + part * (load_to[1] - load_from[1])
        for i in range(n):
            at = OBJECT + i * FINGER
            force = squeeze
            if i > 0:
                force = squeeze * s[at + DRIVE] / others if others > 0.0 else 0.0
            elastic = force + s[at + RELAXED]
            s[at + DEPTH] = DEPTH_UNIT * (elastic / constants[i, TIP_FORCE]) ** (1.0 / constants[i, EXPONENT])
            pace = constants[i, PACE]
            s[at + RELAXED] += STEP * pace * (constants[i, SHARE] * elastic - s[at + RELAXED])
            s[at + FORCE] = force
            stiffness = constants[i, STIFFNESS]
            mu = mu_from[i] + part * (mu_to[i] - mu_from[i])
            if force > 0.0:
                mu *= (force / STATED_AT_N) ** -g
            if s[at + SLIDES] > 0.5:
                mu *= kinetic
            most = mu * force
            before_x, before_y = s[at + BRISTLE_X], s[at + BRISTLE_Y]
            x, y = before_x + s[2] * STEP, before_y + s[3] * STEP
            carried = stiffness * math.sqrt(x * x + y * y)
            s[at + SLIDES] = 0.0
            if carried > most:
                left = most / carried
                gone_x, gone_y = (1.0 - left) * x, (1.0 - left) * y
                gone = math.sqrt(gone_x * gone_x + gone_y * gone_y)
                s[at + SLID_X] += gone_x
                s[at + SLID_Y] += gone_y
                s[at + PATH] += gone
                s[at + SPEED] += gone / (STEP * steps)
                s[at + SLIDES] = 1.0
                x, y = left * x, left * y
            s[at + BRISTLE_X], s[at + BRISTLE_Y] = x, y
            tx = stiffness * x + constants[i, DAMPING] * (x - before_x) / STEP
            ty = stiffness * y + constants[i, DAMPING] * (y - before_y) / STEP
            total = math.sqrt(tx * tx + ty * ty)
            if total > most:
                tx, ty = tx * most / total, ty * most / total
            fx -= tx
            fy -= ty
            s[at + FORCE_X] += tx / steps
            s[at + FORCE_Y] += ty / steps
        s[2] += fx / mass * STEP
        s[3] += fy / mass * STEP
        s[0] += s[2] * STEP
        s[1] += s[3] * STEP


@dataclass(frozen=True)
class Make:
    """What a hand and its object are made of; the scatter between fingers follows from ``seed``."""

    fingers: int = 2
    mu: float = 0.6  # at 5 N
    load: float = 1.0  # [N] weight, with mass = load / GRAVITY
    drive: float = 12.0  # [Hz]
    rate: float = 60.0  # [N/s]
    stiffness: float = 2000.0  # [N/m] of an opposed finger; the thumb is as stiff as all the others
    spread: float = 0.05  # of ln mu between fingers, and of tips
    kinetic: float = 1.0  # friction while sliding over that at rest
    seed: int = 1
    exponent: float = 0.0  # g, by which friction falls with the force


class Plant:
    """The state of a hand and its object, and what it is made of."""

    def __init__(self, make: Make) -> None:
        n, rng = make.fingers, np.random.default_rng([make.seed, 11])
        self.make, self.fingers, self.mass = make, n, make.load / GRAVITY
        self.mu = make.mu * np.exp(make.spread * rng.standard_normal(n))
        stiffness = make.stiffness * np.exp(2.0 * make.spread * rng.standard_normal(n))
        stiffness[0] *= n - 1
        damping = 0.6 * np.sqrt(stiffness * self.mass * stiffness / stiffness.sum())
        self.constants = np.zeros((n, CONSTANTS))
        self.constants[:, BANDWIDTH], self.constants[:, RATE] = make.drive, make.rate
        self.constants[:, STIFFNESS], self.constants[:, DAMPING] = stiffness, damping
        self.constants[:, TIP_FORCE] = 1.1 * np.exp(2.0 * make.spread * rng.standard_normal(n))
        self.constants[:, EXPONENT] = 1.5 + 0.05 * rng.standard_normal(n)
        self.constants[:, SHARE] = 0.3 * np.exp(make.spread * rng.standard_normal(n))
        self.constants[:, PACE] = 3.1 * np.exp(make.spread * rng.standard_normal(n))
        self.state = np.zeros(OBJECT + n * FINGER)
        self.rows = self.state[OBJECT:].reshape(n, FINGER)
        """State of each finger."""

    def advance(self, seconds: float, command: Array, friction: tuple[Array, Array], load: Array) -> None:
        """Go on; ``friction`` multiplies mu, both it and ``load`` [N] are given at beginning and end."""
        steps = round(seconds / STEP)
        mu = self.mu
        advance(self.state, self.constants, self.mass, self.make.kinetic, self.make.exponent, command,
                friction[0] * mu, friction[1] * mu, load[0], load[1], steps)  # fmt: skip

    @property
    def slid(self) -> Array:
        """How far each finger has slid [m], by where its bristle ended up."""
        return np.hypot(self.rows[:, SLID_X], self.rows[:, SLID_Y])

    def least_squeeze(self, load: Array, friction: Array) -> Array:
        """Return the least squeeze S [N] that holds each ``load`` F [N] where all others press alike.

        ``F = S (S / 5 N)^-g (mu_0 + (n - 1)^g mean_i mu_i)``: each of the n - 1 others presses S / (n - 1).
        """
        mu, g = friction * self.mu, self.make.exponent  # (loads, fingers)
        plain = load / (mu[..., 0] + mu[..., 1:].mean(axis=-1) * (self.fingers - 1.0) ** g)
        least: Array = plain * (plain / STATED_AT_N) ** (g / (1.0 - g))
        return least
