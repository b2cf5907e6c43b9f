"""An expensive reference: a Rao-Blackwellised particle filter of the contact, with the same prior.

Exponent, ln nu and zero error are particles. Given them the force is linear in stiffness K, relaxing
stiffness ``G = K c1`` and force bias, which a Kalman filter keeps for each particle, and in the small error
of the present displacement, drawn anew at each sample. Parameters do not move, so particles that the data
have thinned out are moved by Metropolis steps over the whole record so far [Chopin2002], in tempered steps
where one sample tells much [DelMoralDoucetJasra2006]. The prior of ``(K, G)`` is Gaussian with the moments of
the others' prior.
"""

import math

import numpy as np

from benchmarks._designs_contact import (
    BIAS,
    C1,
    DELTA,
    EXPONENT,
    HIGH_C1,
    HIGH_EXPONENT,
    LN_K,
    LN_NU,
    LOW_EXPONENT,
    MEMORY,
    STATES,
    ZERO,
    elastic,
    memory_after,
)
from vegrip.compiled import njit
from vegrip.types import Floats

PARTICLES = 200
MOVES = 3  # Metropolis steps of each particle after resampling
SEED = 5
THETA = 3  # exponent, ln nu, zero error
LINEAR = 3  # K, G, bias
X, ZETA, MEAN = 0, 1, 2  # of a particle's filter: indentation, followed unit force, means, then covariance
FILTER = MEAN + LINEAR + LINEAR * LINEAR


@njit
def filter_sample(
    theta: Floats, f: Floats, dt: float, d: float, force: float, depth: float, noise: Floats, out: Floats
) -> float:
    """Take one sample into the filter ``f`` of a particle; return its log likelihood.

    Writes N, its variance, x and its variance to ``out``. The slope over x is taken at the indentation after
    the sample, as in the fit.
    """
    m, P = f[MEAN : MEAN + LINEAR], f[MEAN + LINEAR :].reshape((LINEAR, LINEAR))
    y = np.zeros(STATES)  # of unit stiffness
    y[EXPONENT], y[LN_NU], y[DELTA], y[MEMORY] = theta[0], theta[1], f[X], f[ZETA]
    y[C1] = min(max(m[1] / m[0], 0.0), HIGH_C1) if m[0] > 0.0 else 0.0
    h, var_d = 1e-3 * depth, noise[0] ** 2
    H, PH = np.zeros(LINEAR), np.zeros(LINEAR)
    measured = d - theta[2]
    x = measured
    for _ in range(3):
        zeta, u = memory_after(y, x, dt, depth, False), elastic(y, x, depth)
        touching = u > y[C1] * zeta
        H[0], H[1], H[2] = (u, -zeta, 1.0) if touching else (0.0, 0.0, 1.0)
        slope = max(m[0], 0.0) * (elastic(y, x + h, depth) - u) / h if touching else 0.0
        off = force - slope * (measured - x)
        for i in range(LINEAR):
            off -= H[i] * m[i]
            PH[i] = P[i, 0] * H[0] + P[i, 1] * H[1] + P[i, 2] * H[2]
        S = H[0] * PH[0] + H[1] * PH[1] + H[2] * PH[2] + noise[1] ** 2 + slope**2 * var_d
        x = measured + var_d * slope * off / S
    along = H[0] * PH[0] + H[1] * PH[1] + slope**2 * var_d  # of N = H[:2] w with the measurement
    spread = along - (H[0] * P[0, 2] + H[1] * P[1, 2]) * H[2]
    for i in range(LINEAR):
        m[i] += PH[i] / S * off
        for j in range(LINEAR):
            P[i, j] -= PH[i] * PH[j] / S
    f[ZETA] = memory_after(y, x, dt, depth, False)
    f[X] = x
    out[0] = max(elastic(y, x, depth) * m[0] - f[ZETA] * m[1], 0.0) if touching else 0.0
    out[1] = max(spread - along * along / S, 0.0)
    out[2], out[3] = x, var_d - (var_d * slope) ** 2 / S
    return float(-0.5 * (math.log(S) + off * off / S))


@njit
def filter_record(
    theta: Floats,
    start: Floats,
    t: Floats,
    d: Floats,
    force: Floats,
    depth: float,
    noise: Floats,
    found: Floats,
    said: Floats,
) -> tuple[float, float]:
    """Filter a record from its start; return the log likelihood before its last sample, and of that."""
    before, last = 0.0, 0.0
    found[:] = start
    for i in range(t.size):
        before += last
        dt = t[i] - t[i - 1] if i > 0 else 2.0
        last = filter_sample(theta, found, dt, d[i], force[i], depth, noise, said)
    return before, last


@njit
def take_sample(
    thetas: Floats, filters: Floats, dt: float, d: float, force: float, depth: float, noise: Floats,
    said: Floats, gained: Floats,
) -> None:  # fmt: skip
    """Take one sample into the filters of all particles; write their log likelihoods of it."""
    for k in range(thetas.shape[0]):
        gained[k] = filter_sample(thetas[k], filters[k], dt, d, force, depth, noise, said[k])


class Particles:
    """The particles of one recording. Arguments as for :func:`particle_filtered`."""

    def __init__(
        self, t: Floats, d: Floats, force: Floats, depth: float, noise: Floats, mean: Floats, prior: Floats
    ) -> None:
        self._record = t, d, force
        self._depth, self._noise = depth, noise
        self._random = np.random.default_rng(SEED)
        at = [EXPONENT, LN_NU, ZERO]
        self._centre, self._std = mean[at], np.sqrt(prior[at])
        self._start = first_filter(mean, prior)
        draws = self._random.standard_normal((PARTICLES, THETA))
        self.thetas = self._centre + self._std * draws
        self.thetas[:, 0] = np.clip(self.thetas[:, 0], LOW_EXPONENT, HIGH_EXPONENT)
        self.filters = np.tile(self._start, (PARTICLES, 1))
        self.log_weights = np.zeros(PARTICLES)
        self.likelihoods = np.zeros(PARTICLES)  # log, of all samples but the last
        self.gained = np.zeros(PARTICLES)  # log likelihood of the last sample
        self.said = np.zeros((PARTICLES, 4))

    def take(self, i: int) -> tuple[float, float, float, float]:
        """Take sample ``i``; return N, std, x, std."""
        t, d, force = self._record
        self.likelihoods += self.gained
        dt = t[i] - t[i - 1] if i else 2.0
        take_sample(
            self.thetas, self.filters, dt, d[i], force[i], self._depth, self._noise, self.said, self.gained
        )
        share = 0.0  # of the sample that the particles have been moved by
        while effective(self.log_weights + (1.0 - share) * self.gained) < 0.5 * PARTICLES:
            more = tempered_share(self.log_weights, self.gained, 1.0 - share)
            self.log_weights += more * self.gained
            share += more
            self._resample()
            for _ in range(MOVES):
                self._move(i, share)
        self.log_weights += (1.0 - share) * self.gained
        w = weights(self.log_weights)
        N, x = w @ self.said[:, 0], w @ self.said[:, 2]
        var_N = w @ (self.said[:, 1] + (self.said[:, 0] - N) ** 2)
        var_x = w @ (self.said[:, 3] + (self.said[:, 2] - x) ** 2)
        return float(N), math.sqrt(var_N), float(x), math.sqrt(var_x)

    def _resample(self) -> None:
        """Draw the particles anew by their weights, systematically."""
        places = (np.arange(PARTICLES) + self._random.random()) / PARTICLES
        kept = np.minimum(np.searchsorted(np.cumsum(weights(self.log_weights)), places), PARTICLES - 1)
        for name in ("thetas", "filters", "likelihoods", "gained", "said"):
            setattr(self, name, getattr(self, name)[kept])
        self.log_weights[:] = 0.0

    def _move(self, i: int, share: float) -> None:
        """Move each particle by one Metropolis step over the samples up to ``i``, the last by its share."""
        upto = slice(0, i + 1)
        t, d, force = (channel[upto] for channel in self._record)
        spread = np.cov(self.thetas.T) + np.diag((1e-9 * self._std) ** 2)
        jumps = self._random.multivariate_normal(np.zeros(THETA), spread * 2.38**2 / THETA, PARTICLES)
        luck = np.log(self._random.random(PARTICLES))
        found, said = np.empty(FILTER), np.empty(4)
        for k in range(PARTICLES):
            new = self.thetas[k] + jumps[k]
            if not LOW_EXPONENT <= new[0] <= HIGH_EXPONENT:
                continue
            before, last = filter_record(new, self._start, t, d, force, self._depth, self._noise, found, said)
            now = self.likelihoods[k] + share * self.gained[k] + self._log_prior(self.thetas[k])
            if luck[k] < before + share * last + self._log_prior(new) - now:
                self.thetas[k], self.filters[k], self.said[k] = new, found, said
                self.likelihoods[k], self.gained[k] = before, last

    def _log_prior(self, theta: Floats) -> float:
        off = (theta - self._centre) / self._std
        return float(-0.5 * off @ off)


def first_filter(mean: Floats, prior: Floats) -> Floats:
    """Return the filter of a particle before the first sample: means and covariance of K, G, bias."""
    K = math.exp(mean[LN_K] + 0.5 * prior[LN_K])
    var_K = K * K * math.expm1(prior[LN_K])
    c, var_c = mean[C1], prior[C1]
    f = np.zeros(FILTER)
    f[X] = -1.0  # [m] far in the air
    f[MEAN : MEAN + LINEAR] = K, c * K, mean[BIAS]
    f[MEAN + LINEAR :] = np.ravel(
        [
            [var_K, c * var_K, 0.0],
            [c * var_K, c * c * var_K + var_c * (var_K + K * K), 0.0],
            [0.0, 0.0, prior[BIAS]],
        ]
    )
    return f


def weights(logs: Floats) -> Floats:
    """Return normalised weights."""
    w = np.exp(logs - np.max(logs))
    normalised: Floats = w / np.sum(w)
    return normalised


def effective(logs: Floats) -> float:
    """Return the effective number of particles."""
    return float(1.0 / np.sum(weights(logs) ** 2))


def tempered_share(logs: Floats, gained: Floats, rest: float) -> float:
    """Return the largest share of the sample, up to ``rest``, that leaves half of the particles effective."""
    low, high = 0.0, rest
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if effective(logs + middle * gained) >= 0.5 * PARTICLES else (low, middle)
    return high


def particle_filtered(
    t: Floats, d: Floats, force: Floats, depth: float, noise: Floats, mean: Floats, prior: Floats
) -> Floats:
    """Return N, std, x, std at each sample, (n, 4).

    Args:
        t: times [s], (n,); gaps begin recovered.
        d: displacements [m], (n,).
        force: normal forces [N], (n,).
        depth: reference depth of the stiffness [m].
        noise: standard deviations of displacement [m] and force [N].
        mean: prior means in the order of the state.
        prior: prior variances in the same order.

    """
    particles = Particles(t, d, force, depth, noise, mean, prior)
    return np.array([particles.take(i) for i in range(t.size)])
