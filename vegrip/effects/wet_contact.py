"""A liquid film between tip and object: ``mu_eff = mu (1 - s h)``, ``h' = -h / tau_f`` in contact.

The film is whole (h = 1) when the contact is made and is squeezed out while it lasts, so friction is low at
first touch and recovers to the dry mu, [Moore1972]_. Between smooth plates a film thins as ``h' ~ -h^3
N`` ([Reynolds1886]_), fast at first and then slowly; a soft rough surface drains through its valleys, and
one time constant is all that slips after different dwells show. A contact that is met in the middle
counts as wet, on the safe side.
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def squeeze(force: float, dt: float, tau_f: float, film: float) -> float:
    """Return the film that is left; 1 out of contact."""
    if force <= 0.0:
        return 1.0
    return film * math.exp(-dt / tau_f)


def friction(friction: float, s_w: float, film: float) -> float:
    """Return the friction coefficient."""
    return friction * (1.0 - s_w * film)


EFFECT = Effect(
    name="wet_contact",
    summary="a film lowers friction until it is squeezed out",
    residual="low friction in short contacts",
    cites=("Moore1972", "Reynolds1886"),
    parameters=(
        Parameter("s_w", "1", 0.3, 0.2, 0.0, 0.95, "share of friction that the film takes", null=0.0),
        Parameter("tau_f", "s", 1.0, 1.0, 1e-4, 1e4, "time to squeeze it out", transform="log"),
    ),
    states=(State("film", "1", "film that is left", initial=1.0),),
    hooks=(hook(squeeze, stage="force", gives=""), hook(friction)),
    channels=("tangential_force", "torque_z"),
    confounded=("friction_ageing",),
    experiment="slips after short and long dwell; wipe and repeat",
)
