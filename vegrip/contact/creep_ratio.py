"""What drives the coupling when the history is not a step of load: the creep ratio ``H``, eq. (48).

The paper replaces ``h(t)`` by a convolution over the load. Normalised so that a step gives back ``h``, it is

    H(t) = delta(t) / delta_e(N_ref(t))

and the paper leaves ``N_ref`` open. With the present force, ``N_ref = N``, a hold at constant
displacement would flatten the profile (``N`` falls), while Section III keeps the profile as it is. The
default takes the largest force of this contact: ``H = 1`` after a step of displacement, ``H = h`` after a
step of load, and unloading does not count.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from vegrip.contact.domain import not_negative, positive
from vegrip.contact.elastic import ElasticLaw
from vegrip.contact.hereditary import sampled
from vegrip.types import Floats

Reference = Literal["largest", "present"]


def creep_ratio(
    times: ArrayLike,
    delta: ArrayLike,
    N: ArrayLike,
    law: ElasticLaw,
    *,
    reference: Reference = "largest",
    fading: float = np.inf,
) -> Floats:
    """``H(t)`` (n,), never below 1, for histories of indentation ``delta`` (n,) [m] and force ``N`` (n,) [N].

    Without contact (``N = 0``) it is 1. ``fading`` [s] lets the largest force be forgotten exponentially;
    at zero it would be the present force.
    """
    t, delta = sampled(times, not_negative("indentation", delta, "m"))
    t, N = sampled(t, not_negative("normal force", N, "N"))
    N_ref = N if reference == "present" else largest_force(t, N, fading)
    delta_e = law.indentation(N_ref)
    touching = (N > 0) & (delta_e > 0)
    return np.maximum(np.divide(delta, delta_e, out=np.ones_like(delta), where=touching), 1.0)


def largest_force(times: ArrayLike, N: ArrayLike, fading: float = np.inf) -> Floats:
    """Largest force [N] of the present contact so far (n,); starts anew when contact is lost (``N = 0``)."""
    t, N = sampled(times, N)
    keep = np.exp(-np.diff(t, prepend=t[:1]) / positive("fading time", fading, "s"))
    largest = np.empty_like(N)
    previous = 0.0
    for i, force in enumerate(N):
        previous = max(force, force + keep[i] * (previous - force)) if force > 0 else 0.0
        largest[i] = previous
    return largest
