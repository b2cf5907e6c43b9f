"""Any history of a contact: displacement imposed for a while, load for a while, contact lost and made again.

Eq. (20) is the law throughout. Where the load is imposed, its recursion is solved for the elastic force.
Where the displacement is imposed and the force would become a pull, the contact opens and the free
surface recovers at zero force; it closes when the imposed displacement reaches the surface again.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vegrip.contact.elastic import ElasticLaw
from vegrip.contact.hereditary import check_times, closed
from vegrip.contact.prony import Relaxation
from vegrip.errors import DomainError
from vegrip.types import Floats


@dataclass(frozen=True)
class ContactHistory:
    """A contact over time; all arrays have the shape of ``times`` (n,)."""

    times: Floats  # [s]
    indentation: Floats  # [m] of the fingertip's surface; in the air, of the dent that is left
    normal_force: Floats  # [N]
    elastic_force: Floats  # [N] N_e(indentation)
    in_contact: NDArray[np.bool_]


def solve(
    times: ArrayLike,
    law: ElasticLaw,
    g: Relaxation,
    *,
    indentation: ArrayLike = np.nan,
    normal_force: ArrayLike = np.nan,
) -> ContactHistory:
    """Solve eq. (20) for what was not imposed.

    At each sample exactly one of ``indentation`` (n,) [m] and ``normal_force`` (n,) [N] is a number, the
    other NaN. A negative indentation is a gap. Exact when the elastic force is linear between the
    samples; equal times are a jump; the instants at which contact is lost and made are resolved to one
    sample.

    Raises:
        DomainError: both or neither imposed, a negative force imposed, times that run backwards.

    """
    t = np.ascontiguousarray(times, dtype=np.float64)
    check_times(t)
    delta, N = _imposed(indentation, t), _imposed(normal_force, t)
    if not np.all(np.isnan(delta) ^ np.isnan(N)):
        raise DomainError("exactly one of indentation and normal force must be imposed at each sample")
    if np.any(N < 0):
        raise DomainError(
            "a contact that does not stick cannot be pulled: the normal force must not be negative"
        )
    elastic = np.where(np.isnan(delta), np.nan, law.force(np.fmax(delta, 0.0)))
    elastic, N = closed(t, elastic, N, (g.amplitudes, g.rates))
    return ContactHistory(t, law.indentation(np.maximum(elastic, 0.0)), N, elastic, N > 0)


def _imposed(values: ArrayLike, t: Floats) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    if np.any(np.isinf(array)):
        raise DomainError("an imposed value is not finite")
    try:
        return np.broadcast_to(array, t.shape)
    except ValueError:
        raise DomainError(f"a history of shape {array.shape} does not fit {len(t)} sample times") from None
