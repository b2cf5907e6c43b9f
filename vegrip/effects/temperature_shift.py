"""Temperature: softer and faster when warm, ``dT = T - T_ref``.

``N_e *= 1 - alpha dT`` and ``nu_i -> nu_i / a_T`` with ``log10 a_T = -s dT / (1 + dT / C_2)``, the shift of
[WilliamsLandelFerry1955]_ with ``s = C_1 / C_2``. With ``C_2 = T_ref`` in kelvin it is Arrhenius' law,
exactly, for an activation energy ``E = s R T_ref^2 ln 10``. Far below T_ref the law ends (``dT = -C_2``);
it is kept at half way.
"""

from vegrip.effects.contract import Effect, hook
from vegrip.parameters import Parameter

DECADES = 30.0  # limit of log10 a_T


def elastic(elastic_force: float, temperature: float, reference_temperature: float, alpha_T: float) -> float:
    """Return the elastic force [N]."""
    return elastic_force * max(1.0 - alpha_T * (temperature - reference_temperature), 0.0)


def rate(
    relaxation_rate: float, temperature: float, reference_temperature: float, s_T: float, C_2: float
) -> float:
    """Return the factor on all rates, ``1 / a_T``."""
    if s_T == 0.0:
        return relaxation_rate
    dT = max(temperature - reference_temperature, -0.5 * C_2)
    decades = s_T * dT / (1.0 + dT / C_2)
    return float(relaxation_rate * 10.0 ** min(max(decades, -DECADES), DECADES))


EFFECT = Effect(
    name="temperature_shift",
    summary="warm material is softer and relaxes faster",
    residual="slow change of gain that follows T, proportional to N",
    cites=("WilliamsLandelFerry1955",),
    parameters=(
        Parameter("alpha_T", "1/K", 0.004, 0.004, -0.02, 0.1, "loss of elastic force per kelvin", null=0.0),
        Parameter("s_T", "1/K", 0.03, 0.03, 0.0, 0.5, "decades of rate per kelvin", null=0.0),
        Parameter("C_2", "K", 200.0, 0.5, 20.0, 1000.0, "curvature; T_ref for Arrhenius", transform="log"),
    ),
    hooks=(hook(elastic), hook(rate, stage="elastic", gives="relaxation_rate")),
    confounded=("force_drift", "mullins_softening"),
    experiment="two soaks, temperature up and down again; always record it",
)
