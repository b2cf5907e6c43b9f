"""A pressure profile that does not follow the coupling of radius and pressure.

``ln k = (1 - s) ln k_c + s ln k_inf``, ``s = s_k u``, ``u' = (1 - u) / tau_k`` in contact, u = 0 at touch.

k_c is the exponent by [TiezziKao2007]_, eq. (36). With ``s_k = 1`` the profile leaves it for its own k_inf
with the time constant tau_k; with tau_k short against the contact, k is a constant. A load dependence of
k_inf is left out: k acts on nothing but the torque at slip, and on that at most by 13 % (k from 2 to
infinity).
"""

import math

from vegrip.effects.contract import Effect, State, hook
from vegrip.parameters import Parameter


def settle(force: float, dt: float, tau_k: float, settled: float) -> float:
    """Return u, how far the profile is on its way to its own exponent; 0 out of contact."""
    if force <= 0.0:
        return 0.0
    return 1.0 - (1.0 - settled) * math.exp(-dt / tau_k)


def profile(exponent: float, s_k: float, k_inf: float, settled: float) -> float:
    """Return the pressure exponent k."""
    return float(exponent * (k_inf / exponent) ** (s_k * settled))


EFFECT = Effect(
    name="pressure_profile",
    summary="the pressure profile tends to an exponent of its own",
    residual="only in the torque at slip, at most 13 %",
    cites=("TiezziKao2007",),
    parameters=(
        Parameter("s_k", "1", 1.0, 0.3, 0.0, 1.0, "share of the own profile", null=0.0),
        Parameter("k_inf", "1", 3.0, 0.4, 1.0, 100.0, "exponent it tends to", transform="log"),
        Parameter("tau_k", "s", 0.3, 1.0, 1e-4, 1e4, "time constant", transform="log"),
    ),
    states=(State("settled", "1", "how far the profile is on its way"),),
    hooks=(hook(settle, stage="force", gives=""), hook(profile)),
    channels=("torque_z",),
    confounded=("contact_radius_law",),
    experiment="pure twists to slip after two hold times, with a contact image",
    imitated_by="where only torques show it, a radius other than {radius:.3g} m has the same effect",
)
