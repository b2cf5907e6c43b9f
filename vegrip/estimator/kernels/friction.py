"""What slipping and not slipping say about friction: of its law over the load (:mod:`.load_law`).

``u`` is the utilisation the load would have at mu = 1, so slip happens at ``mu(N) = u``. One sample teaches
nothing, and a second of wrong ones no more than its noise allows:

* **A slide** measures ``ln mu - g l`` at the present load, by the mean of its ln u: Gaussian update. It
  counts from SLIDE samples on, as long as u stays the same, as friction demands. A slide far above what is
  believed counts only when a later one confirms it; one far below counts at once, because it asks for more
  force.
* **Not slipping** at u says only mu(N) > u: ``P(stick) = Phi((ln mu - g l - ln u) / s)``, folded in by
  matching the first two moments. The u is the least one of SUSTAINED seconds, more than a fault lasts that
  nothing else shows. It counts once per loading, for its largest u, and only where no earlier loading has
  shown as much: a thousand looks at the same load are one piece of evidence, and counted as a thousand they
  push mu away without end.
* **Scatter** from slip to slip is learned as well: fingers that always slip at the same mu are believed
  sooner.
* **Forgetting**: the variance grows with time and with every new contact, up to the prior.
"""

import math

from vegrip.estimator.kernels.generated import *
from vegrip.estimator.kernels.load_law import *
from vegrip.estimator.normal_law import inverse_mills

NEWS = 1.03  # a record counts again when it is topped by this factor: noise alone tops it by less
VAGUE = 0.1  # relative std of u beyond which not slipping says nothing (light touch: noise is all there is)
SLIDE = 3.0  # samples of slip in a row before it is believed
STEADY_SLIDE = 0.1  # change of ln u beyond which a slide is no longer one with the same friction
SUSTAINED = 1.1  # [s] for which a load must be held to show anything
FAR_ABOVE = 2.5  # standard deviations above the belief beyond which a slide needs another one to confirm it
ALIKE = 0.2  # of ln u, between a slide and the one that confirms it
PRIOR_EVENTS = 3.0  # slides that the stated scatter is worth
SLID, HELD = 1.0, 2.0  # events


def learn_friction(
    m: Floats, dt: float, u: float, relative_std: float, slip: float, touching: bool, sound: bool
) -> None:
    """Fold in one sample; ``u`` is NaN where load or force are not known, ``slip`` where it is not sensed.

    A ``slip`` between 0 and 1 is no flag, and counts as not sensed.

    Nothing is learned where the estimate is not ``sound``.
    """
    inflate_friction(m, dt, touching)
    known = 0.0 < u < math.inf and relative_std < 10.0 and touching and sound
    if not known or not (slip <= 0.0 or slip >= 1.0):
        m.friction.slide_count = m.friction.held_time = 0.0
        return
    noise = relative_std * relative_std + m.friction.scatter_var
    if slip >= 0.5:
        m.friction.held_time = 0.0
        count_slide(m, math.log(u), noise)
        return
    if m.friction.sliding > 0.0:
        new_loading(m)
        m.friction.smooth = 0.0
    m.friction.sliding = m.friction.slide_count = 0.0
    if relative_std > VAGUE:
        m.friction.smooth = m.friction.held_time = 0.0
        return
    u = u * math.exp(
        m.friction.exponent * m.friction.load
    )  # of loads at different forces, at the reference load
    # a peak of noise is no evidence
    m.friction.smooth += (1.0 - math.exp(-dt / 0.02)) * (u - m.friction.smooth)
    follow_loading(m, m.friction.smooth)
    count_stick(m, dt, u, noise)


def count_slide(m: Floats, ln_u: float, noise: float) -> None:
    """One sample of slip: believed from SLIDE of them on, while u stays the same."""
    count = m.friction.slide_count
    if count == 0.0:
        m.friction.slide_mean = ln_u
    if count < 0.0 or abs(ln_u - m.friction.slide_mean) > STEADY_SLIDE + 3.0 * math.sqrt(noise):
        m.friction.slide_count = -1.0 if count >= SLIDE or count < 0.0 else 0.0
        return
    count += 1.0
    m.friction.slide_count = count
    m.friction.slide_mean += (ln_u - m.friction.slide_mean) / count
    if count == SLIDE and not is_confirmed(m, m.friction.slide_mean, noise):
        m.friction.slide_count = -1.0
        return
    if count >= SLIDE:
        update_by_slip(m, m.friction.slide_mean, noise, count == SLIDE)


def is_confirmed(m: Floats, ln_u: float, noise: float) -> bool:
    """Whether a slide at ``ln_u`` is to be believed; one far above the belief waits for another like it."""
    above = (ln_u - base_mean(m)) / math.sqrt(base_variance(m, m.friction.load) + noise)
    alike = abs(ln_u - m.friction.unconfirmed) < ALIKE
    m.friction.unconfirmed = ln_u if above > FAR_ABOVE else math.inf
    return bool(above <= FAR_ABOVE or alike)


def update_by_slip(m: Floats, ln_u: float, noise: float, first: bool) -> None:
    """Gaussian update, from before this loading: that it held until now says nothing more.

    Later samples of the same slide are the ``first`` one again, better averaged.
    """
    off, variance = ln_u - base_mean(m), base_variance(m, m.friction.load)
    if first and m.friction.events > 0.0:
        excess = off * off - variance - (noise - m.friction.scatter_var)
        gain = 1.0 / (PRIOR_EVENTS + m.friction.events)
        grown = m.friction.scatter_var + gain * (max(excess, 0.0) - m.friction.scatter_var)
        noise += grown - m.friction.scatter_var
        m.friction.scatter_var = grown
    note_event(m, SLID, ln_u, noise)
    observe_base(m, off / (variance + noise), 1.0 / (variance + noise))
    m.friction.sliding = 1.0
    m.friction.best = m.friction.peak = m.friction.proven = 0.0
    if first:
        m.friction.events += 1.0


def new_loading(m: Floats) -> None:
    """What is known now is what the next loading starts from."""
    m.friction.loadings += 1.0
    m.friction.best = max(m.friction.best, m.friction.proven)
    m.friction.base_ln, m.friction.base_exponent = m.friction.ln_mu, m.friction.exponent
    m.friction.base_var, m.friction.base_exponent_var = m.friction.var, m.friction.exponent_var
    m.friction.base_cov = m.friction.cov
    m.friction.peak = m.friction.proven = m.friction.held_time = 0.0


def follow_loading(m: Floats, u: float) -> None:
    """Note the largest utilisation of this loading; when it has fallen to half, the next one begins."""
    if u < 0.5 * m.friction.peak:
        new_loading(m)
    m.friction.peak = max(m.friction.peak, u)


def count_stick(m: Floats, dt: float, u: float, noise: float) -> None:
    """One sample without slip: after SUSTAINED, the least u of that time is proven."""
    if m.friction.held_time == 0.0:
        m.friction.held_least = u
    m.friction.held_least = min(m.friction.held_least, u)
    m.friction.held_time += dt
    if m.friction.held_time >= SUSTAINED:
        update_by_stick(m, m.friction.held_least, noise)
        m.friction.held_time = 0.0


def update_by_stick(m: Floats, u: float, noise: float) -> None:
    """Stick at utilisation ``u``: the posterior of this loading, from its beginning, with its largest u."""
    if u <= m.friction.proven:
        return
    m.friction.proven = u
    if u <= NEWS * m.friction.best:
        return
    ln_u = math.log(u) - m.friction.exponent * m.friction.load
    spread = math.sqrt(base_variance(m, m.friction.load) + noise)
    z = (base_mean(m) - ln_u) / spread
    ratio = inverse_mills(z)
    note_event(m, HELD, ln_u, noise)
    observe_base(m, ratio / spread, ratio * (z + ratio) / (spread * spread))


def base_mean(m: Floats) -> float:
    """Return the mean of ln mu at the present load, before the present loading."""
    return m.friction.base_ln - m.friction.base_exponent * m.friction.load


def note_event(m: Floats, what: float, ln_u: float, noise: float) -> None:
    """Tell those who share what is believed of friction (:mod:`vegrip.grip.friction_belief`)."""
    m.friction.event, m.friction.event_ln_u, m.friction.event_noise = what, ln_u, noise


def inflate_friction(m: Floats, dt: float, touching: bool) -> None:
    """Friction may change: slowly with time, and with every new contact; never wider than the prior.

    Where slips scatter less than was stated, regrasping changes less as well.
    """
    grown = m.set.mu_drift * m.set.mu_drift * dt
    if touching and m.friction.touching == 0.0:
        grown += (
            m.set.regrasp * m.set.regrasp * min(m.friction.scatter_var / (m.set.scatter * m.set.scatter), 1.0)
        )
        m.friction.sliding = m.friction.slide_count = 0.0
        m.friction.smooth = 0.0
        new_loading(m)
    m.friction.touching = 1.0 if touching else 0.0
    limit = m.set.mu_prior_var
    m.friction.var = min(m.friction.var + grown, max(limit, m.friction.var))
    m.friction.base_var = min(m.friction.base_var + grown, max(limit, m.friction.base_var))
