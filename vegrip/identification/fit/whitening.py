"""Whitening: from a residual of the normal force to independent errors of variance one.

What the model leaves is noise of the force sensor, white and slow, and what the error of the smoothed motion
does to the modelled force,

    ``residual = k tip + h speed + b + m s + e``,   ``b+ = b exp(-dt / tau) + noise``

with the tip where the motion is or where a play has left it and a number ``s ~ N(0, 1)`` for each gap of the
recording (:class:`Sensitivity`), a state-space model whose one-step prediction errors, over their standard
deviations, are independent [DurbinKoopman2012]_. Its gains do not depend on the residual, so it is a matrix:
the same for the derivatives. This is the likelihood of a filter that carries the displacement as a noisy
state, linear in the force.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit
from vegrip.identification.fit.motion import Motion
from vegrip.model import BASE, ContactModel
from vegrip.types import Floats

MIN_PLAY_STDS = 1.0  # standard deviations of the displacement, below which a play is none
SHAKE_STDS = 1e-4  # of them, by which a motion is shaken to see whether the tip follows
RESTING_SHARE = 1e-3  # of the shaking, below which it does not
Answer = Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """The error of the force that an error of the motion makes.

    It reaches the force by four ways:

    * by position, times the stiffness;
    * by speed, where a model has drag or damping, and the more where the motion bends: when between two
      samples it does is not known;
    * behind backlash, where the tip rests until the gap is crossed, it stays what it was when the tip last
      moved;
    * by memory, of what moved while rows were lost (:mod:`vegrip.identification.fit.gaps`).
    """

    position: Floats  # (n,) [N/m]; 0 in air
    speed: Floats  # (n,) [N s/m]
    # (n,) whether the tip moves with the drive; where not, the error of its position stays
    follows: NDArray[np.bool_]
    bend: Floats  # (n,) [N] std of what is not known because the motion bends between samples
    memory: Floats  # (n,) [N] what one standard deviation of the motion in the gap before leaves
    after_gaps: NDArray[np.int64]  # the first row after each gap


def by_position(stiffness: Floats) -> Sensitivity:
    """Return the sensitivity (n,) of a force without effect of speed or backlash; ``stiffness`` [N/m]."""
    none = np.zeros(stiffness.size)
    ever = np.ones(stiffness.size, dtype=bool)
    return Sensitivity(stiffness, none, ever, none, none, np.zeros(0, dtype=np.int64))


def feels_speed(model: ContactModel) -> bool:
    """Whether an effect that was added takes the speed."""
    return any(
        "speed" in arguments_of(h.function) for e in model.effects if e.name not in BASE for h in e.hooks
    )


def has_play(model: ContactModel) -> bool:
    moves = ("x", "compliance")
    return any(e.states and h.stage == "tip" and h.gives in moves for e in model.effects for h in e.hooks)


def arguments_of(function: object) -> tuple[str, ...]:
    """Return the names of the arguments of ``function``; none of one without Python code."""
    code = getattr(function, "__code__", None)
    return tuple(code.co_varnames[: code.co_argcount]) if code is not None else ()


def follows(indentation: Answer, first: Floats, motion: Floats, noise: float) -> NDArray[np.bool_]:
    """Return whether the tip follows each step (n,) of a motion that is shaken a little.

    ``indentation`` of the tip [m], by what is added to the ``motion`` (n,) [m]. A tip that is never farther
    from where the motion takes it than the ``noise`` [m] has no backlash that could be seen.
    """
    still = indentation(np.zeros(first.size))
    away = (still - motion)[still > 0.0]
    if not away.size or np.ptp(away) < 2.0 * MIN_PLAY_STDS * noise:
        return np.ones(first.size, dtype=bool)
    shake = SHAKE_STDS * noise * np.random.default_rng(0).standard_normal(first.size)
    moved = indentation(shake) - still
    rests = np.abs(np.diff(moved)) < RESTING_SHARE * np.abs(np.diff(shake))
    out: NDArray[np.bool_] = np.r_[True, ~rests | (first[1:] > 0.0)]
    return out


def by_speed(force: Answer, t: Floats, first: Floats, motion: Motion) -> tuple[Floats, Floats]:
    """Return what the error of the speed does (n,) [N s/m], and the std of what a bend hides (n,) [N].

    ``force`` [N] by the speed (n,) [m/s]. The slope is that over the standard error of the speed, as wide as
    the force is bent within it.
    """
    steps = np.diff(motion.displacement) / np.diff(t)
    jump = first[1:] > 0.0
    steps[jump] = 0.0
    before, after = np.r_[0.0, steps], np.r_[steps, 0.0]
    before[first > 0.0] = after[first > 0.0]
    ends = np.r_[jump, True]
    after[ends] = before[ends]
    std = np.maximum(speed_std(t, first, motion.pull, motion.push, motion.start), 1e-12)
    middle = 0.5 * (before + after)
    slope = (force(middle + std) - force(middle - std)) / (2.0 * std)
    return slope, np.abs(force(after) - force(before)) / np.sqrt(12.0)


@njit
def speed_std(t: Floats, first: Floats, pull: Floats, push: Floats, start: Floats) -> Floats:
    """Return the standard error (n,) [m/s] of the smoothed speed after each sample."""
    n = t.shape[0]
    out = np.zeros(n)
    dd, dv, vv = 0.0, 0.0, 0.0
    for i in range(n):
        if first[i] > 0.0:
            dd, dv, vv = start[i, 0], start[i, 1], start[i, 2]
        out[i] = np.sqrt(max(vv, 0.0))
        if i + 1 < n:
            dt = t[i + 1] - t[i]
            a, b = -dt * pull[i, 0], 1.0 - dt * pull[i, 1]
            vv, dv, dd = (
                a * a * dd + 2.0 * a * b * dv + b * b * vv + (push[i] * dt) ** 2,
                a * dd + (b + a * dt) * dv + b * dt * vv,
                dd + 2.0 * dt * dv + dt * dt * vv,
            )
    return out


@dataclass(frozen=True)
class ForceNoise:
    """Noise of the normal force: white std [N] (one or of every row), slow std [N], its time constant [s]."""

    white: float | Floats
    slow: float = 0.0
    time: float = 2.0


class Whitener:
    """The whitening matrix of a recording, as a recursion.

    Args:
        t: (n,) [s].
        first: (n,) 1 where an episode begins.
        motion: the smoothed motion.
        sensitivity: of the model's force to errors of it.
        noise: of the force.
        used: (n,) rows with a force that counts.

    """

    def __init__(
        self,
        t: Floats,
        first: Floats,
        motion: Motion,
        sensitivity: Sensitivity,
        noise: ForceNoise,
        used: Floats,
    ) -> None:
        s = sensitivity
        seen = np.stack([s.position, 0.5 * s.speed, s.memory], axis=1)
        same_gap = np.ones(t.size)
        same_gap[s.after_gaps] = 0.0
        self._beside = (t, first, motion.pull, seen, s.follows.astype(np.float64), same_gap, noise.time)
        white = np.square(noise.white) + np.square(s.bend)
        self._chain = (*self._beside, motion.push, motion.start, white, noise.slow**2)
        self._gain, self._scale = gains(*self._chain, used)
        self._by_position = None
        if s.follows.all() and not seen[:, 1:].any():
            wanders = noise.slow > 0.0
            kept = np.exp(-np.diff(t, prepend=t[0]) / noise.time) if wanders else np.ones(t.size)
            gain = np.ascontiguousarray(self._gain[:, (0, 1, 4)])
            self._by_position = (t, first, motion.pull, s.position, kept, gain, self._scale)

    def __call__(self, columns: Floats) -> Floats:
        """Whiten residuals or derivatives, (n,) or (n, m); rows that do not count become 0."""
        if columns.ndim == 1 and self._by_position is not None:
            return whiten_by_position(*self._by_position, np.ascontiguousarray(columns))
        matrix = np.ascontiguousarray(columns if columns.ndim == 2 else columns[:, None])
        white = whiten(*self._beside, self._gain, self._scale, matrix)
        return white if columns.ndim == 2 else np.ascontiguousarray(white[:, 0])

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of the residual of each row by itself (n,) [N]."""
        _, alone = gains(*self._chain, np.zeros(self._scale.size))
        return 1.0 / alone

    @property
    def log_scale(self) -> Floats:
        """Logarithm of the standard deviation of each row (n,): the likelihood's part without residual."""
        return -np.log(np.where(self._scale > 0.0, self._scale, 1.0))


@njit
def transition(dt: float, pull: Floats, follows: float, decay: float, same: float, A: Floats) -> None:
    """Write the step of (error, speed after, speed before, tip, b, s) into A (6, 6)."""
    A[:, :] = 0.0
    A[0, 0], A[0, 1] = 1.0, dt
    A[1, 0], A[1, 1] = -dt * pull[0], 1.0 - dt * pull[1]
    A[2, 1] = 1.0
    A[3, 0], A[3, 1], A[3, 3] = follows, follows * dt, 1.0 - follows
    A[4, 4] = decay
    A[5, 5] = same


@njit
def begun(start: Floats, S_b: float, P: Floats) -> None:
    """Write the covariance at the beginning of an episode into P (6, 6): the tip is where the motion is."""
    P[:, :] = 0.0
    P[0, 0] = P[0, 3] = P[3, 0] = P[3, 3] = start[0]
    for a in (1, 2):
        P[a, 0] = P[0, a] = P[a, 3] = P[3, a] = start[1]
        P[a, 1] = P[a, 2] = start[2]
    P[4, 4] = S_b
    P[5, 5] = 1.0


@njit
def multiplied(A: Floats, P: Floats, out: Floats) -> None:
    """Write ``(A P)'`` into out, most of A being zero; of that in turn it is ``A P A'``."""
    out[:, :] = 0.0
    for a in range(6):
        for c in range(6):
            if A[a, c] != 0.0:
                for b in range(6):
                    out[b, a] += A[a, c] * P[c, b]


@njit
def gains(
    t: Floats,
    first: Floats,
    pull: Floats,
    seen: Floats,
    follows: Floats,
    same_gap: Floats,
    time: float,
    push: Floats,
    start: Floats,
    white: Floats,
    S_b: float,
    used: Floats,
) -> tuple[Floats, Floats]:
    """Return the Kalman gains (n, 6), and one over the std of the innovation (n,).

    Rows that are not ``used`` have no gain; where none is, one over the std of every row by itself.
    """
    n = t.shape[0]
    gain, scale = np.zeros((n, 6)), np.zeros(n)
    P, A, B, g = np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6)), np.zeros(6)
    none = not used.any()
    for i in range(n):
        if first[i] > 0.0:
            begun(start[i], S_b, P)
        k, h, m = seen[i, 0], seen[i, 1], seen[i, 2]
        for a in range(6):  # loops, for an array of its own in each row takes as long as all the rest
            g[a] = h * (P[a, 1] + P[a, 2]) + k * P[a, 3] + P[a, 4] + m * P[a, 5]
        S = h * (g[1] + g[2]) + k * g[3] + g[4] + m * g[5] + white[i]
        if used[i] > 0.0 or none:
            scale[i] = 1.0 / np.sqrt(S)
        if used[i] > 0.0:
            for b in range(6):
                gain[i, b] = g[b] / S
                for a in range(6):
                    P[a, b] -= g[a] * gain[i, b]
        if i + 1 < n and first[i + 1] == 0.0:
            dt = t[i + 1] - t[i]
            decay = np.exp(-dt / time)
            transition(dt, pull[i], follows[i + 1], decay, same_gap[i + 1], A)
            multiplied(A, P, B)
            multiplied(A, B, P)
            P[1, 1] += (push[i] * dt) ** 2
            P[4, 4] += S_b * (1.0 - decay * decay)
            P[5, 5] += 1.0 - same_gap[i + 1]
    return gain, scale


@njit
def whiten(
    t: Floats,
    first: Floats,
    pull: Floats,
    seen: Floats,
    follows: Floats,
    same_gap: Floats,
    time: float,
    gain: Floats,
    scale: Floats,
    columns: Floats,
) -> Floats:
    """Return the innovations of ``columns`` (n, m) over their standard deviations."""
    n, m = columns.shape
    out = np.zeros((n, m))
    x = np.zeros((m, 6))
    for i in range(n):
        if first[i] > 0.0:
            x[:, :] = 0.0
        else:
            dt = t[i] - t[i - 1]
            e = np.exp(-dt / time)
            p0, p1, f = pull[i - 1, 0], pull[i - 1, 1], follows[i]
            for c in range(m):
                speed = x[c, 1]
                x[c, 1] = speed - dt * (p0 * x[c, 0] + p1 * speed)
                x[c, 0] += dt * speed
                x[c, 2] = speed
                x[c, 3] += f * (x[c, 0] - x[c, 3])
                x[c, 4] *= e
                x[c, 5] *= same_gap[i]
        if scale[i] > 0.0:
            k, h, memory = seen[i, 0], seen[i, 1], seen[i, 2]
            for c in range(m):
                v = columns[i, c] - h * (x[c, 1] + x[c, 2]) - k * x[c, 3] - x[c, 4] - memory * x[c, 5]
                for j in range(6):
                    x[c, j] += gain[i, j] * v
                out[i, c] = v * scale[i]
    return out


@njit
def whiten_by_position(
    t: Floats,
    first: Floats,
    pull: Floats,
    position: Floats,
    kept: Floats,
    gain: Floats,
    scale: Floats,
    column: Floats,
) -> Floats:
    """Return what :func:`whiten` does of one ``column`` (n,) where error of the position alone is felt.

    More than twice as fast, for the tip is where the motion is. ``kept`` (n,) of the slow noise since the row
    before; ``gain`` (n, 3) of error, speed and slow noise.
    """
    n = t.shape[0]
    out = np.zeros(n)
    error, speed, slow = 0.0, 0.0, 0.0
    for i in range(n):
        if first[i] > 0.0:
            error, speed, slow = 0.0, 0.0, 0.0
        else:
            dt = t[i] - t[i - 1]
            before = speed
            speed = before - dt * (pull[i - 1, 0] * error + pull[i - 1, 1] * before)
            error += dt * before
            slow *= kept[i]
        if scale[i] > 0.0:
            v = column[i] - position[i] * error - slow
            error += gain[i, 0] * v
            speed += gain[i, 1] * v
            slow += gain[i, 2] * v
            out[i] = v * scale[i]
    return out
