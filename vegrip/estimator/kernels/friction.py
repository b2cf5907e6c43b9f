"""What slipping and not slipping say about friction: ``ln mu ~ N(mean, variance)``.

``u`` is the utilisation the load would have at mu = 1, so slip happens at ``mu = u``.

* A slip is a measurement of ln mu: Gaussian update with ln u.
* Not slipping at u says only mu > u: ``P(stick) = Phi((ln mu - ln u) / s)``, folded in by matching the first
  two moments. It counts once per loading, for its largest u, and only where no earlier loading has shown
  as much: a thousand looks at the same load are one piece of evidence, and counted as a thousand they push
  mu away without end.
* Forgetting: the variance grows with time and with every new contact, up to the prior.
"""

import math

from vegrip.estimator.kernels.generated import (
    FRI_BASE_LN,
    FRI_BASE_VAR,
    FRI_BEST,
    FRI_EVENTS,
    FRI_LN_MU,
    FRI_PEAK,
    FRI_SINCE,
    FRI_SLIDING,
    FRI_SMOOTH,
    FRI_TOUCHING,
    FRI_VAR,
    SET_MU_DRIFT,
    SET_MU_PRIOR_VAR,
    SET_REGRASP,
    SET_SCATTER,
    Floats,
)

NEWS = 1.03  # a record counts again when it is topped by this factor: noise alone tops it by less
VAGUE = 0.1  # relative std of u beyond which not slipping says nothing (light touch: noise is all there is)


def learn_friction(m: Floats, dt: float, u: float, relative_std: float, slip: float, touching: bool) -> None:
    """Fold in one sample; ``u`` is NaN where load or force are not known, ``slip`` where it is not sensed."""
    forget(m, dt, touching)
    m[FRI_SINCE] += dt
    if not (0.0 < u < math.inf and relative_std < 10.0 and touching) or math.isnan(slip):
        return
    noise = relative_std * relative_std + m[SET_SCATTER] * m[SET_SCATTER]
    if slip >= 0.5:
        if m[FRI_SLIDING] < 0.5:
            slipped(m, math.log(u), noise)
        m[FRI_SLIDING] = 1.0
        return
    if m[FRI_SLIDING] > 0.5:
        new_loading(m)
        m[FRI_SMOOTH] = 0.0
    m[FRI_SLIDING] = 0.0
    if relative_std > VAGUE:
        m[FRI_SMOOTH] = 0.0
        return
    m[FRI_SMOOTH] += (1.0 - math.exp(-dt / 0.02)) * (u - m[FRI_SMOOTH])  # a peak of noise is no evidence
    held(m, m[FRI_SMOOTH], noise)


def slipped(m: Floats, ln_u: float, noise: float) -> None:
    """Gaussian update, from before this loading: that it held until now says nothing more."""
    gain = m[FRI_BASE_VAR] / (m[FRI_BASE_VAR] + noise)
    m[FRI_LN_MU] = m[FRI_BASE_LN] + gain * (ln_u - m[FRI_BASE_LN])
    m[FRI_VAR] = (1.0 - gain) * m[FRI_BASE_VAR]
    m[FRI_EVENTS] += 1.0
    m[FRI_BEST] = m[FRI_PEAK] = 0.0
    new_loading(m)


def new_loading(m: Floats) -> None:
    """What is known now is what the next loading starts from."""
    m[FRI_BEST] = max(m[FRI_BEST], m[FRI_PEAK])
    m[FRI_BASE_LN] = m[FRI_LN_MU]
    m[FRI_BASE_VAR] = m[FRI_VAR]
    m[FRI_PEAK] = 0.0


def held(m: Floats, u: float, noise: float) -> None:
    """Stick at utilisation ``u``: the posterior of this loading, from its beginning, with its largest u."""
    if u < 0.5 * m[FRI_PEAK]:
        new_loading(m)
    if u <= m[FRI_PEAK]:
        return
    m[FRI_PEAK] = u
    if u <= NEWS * m[FRI_BEST]:
        return
    spread = math.sqrt(m[FRI_BASE_VAR] + noise)
    z = (m[FRI_BASE_LN] - math.log(u)) / spread
    ratio = inverse_mills(z)
    share = m[FRI_BASE_VAR] / spread
    m[FRI_LN_MU] = m[FRI_BASE_LN] + share * ratio
    m[FRI_VAR] = max(m[FRI_BASE_VAR] - share * share * ratio * (z + ratio), 1e-8)


def inverse_mills(z: float) -> float:
    """``phi(z) / Phi(z)``, stable far in the lower tail."""
    if z < -8.0:
        return -z - 1.0 / z
    return math.exp(-0.5 * z * z) * 0.3989422804014327 / (0.5 * math.erfc(-z * 0.7071067811865476))


def forget(m: Floats, dt: float, touching: bool) -> None:
    """Friction may change: slowly with time, and with every new contact; never wider than the prior."""
    grown = m[SET_MU_DRIFT] * m[SET_MU_DRIFT] * dt
    if touching and m[FRI_TOUCHING] < 0.5:
        grown += m[SET_REGRASP] * m[SET_REGRASP]
        m[FRI_SLIDING] = 0.0
        m[FRI_SMOOTH] = 0.0
        new_loading(m)
    m[FRI_TOUCHING] = 1.0 if touching else 0.0
    limit = m[SET_MU_PRIOR_VAR]
    m[FRI_VAR] = min(m[FRI_VAR] + grown, max(limit, m[FRI_VAR]))
    m[FRI_BASE_VAR] = min(m[FRI_BASE_VAR] + grown, max(limit, m[FRI_BASE_VAR]))
