"""Relaxation at several separate times: ``N = ... - sum_i c_i z_i``, ``z_i' = nu_i (N_e - z_i)``, c_i >= 0.

The discrete spectrum of [TiezziKao2007]_, eq. (15), on five rates a decade apart, ``nu_i = nu_s 10^(i-1)``,
from 0.01 to 100 1/s or up to half a decade beside; amplitudes that are not needed end at their bound 0. More
than 95 % of the force does not relax: a larger sum counts as that.
"""

from vegrip.effects.contract import Effect, State, hook
from vegrip.effects.relaxation import branch
from vegrip.parameters import Parameter

MOST = 0.95  # of the force that relaxes


def force(
    force: float,
    elastic_force: float,
    elastic_before: float,
    dt: float,
    relaxation_rate: float,
    relaxation_strength: float,
    nu_s: float,
    c_s1: float,
    c_s2: float,
    c_s3: float,
    c_s4: float,
    c_s5: float,
    zS1: float,
    zS2: float,
    zS3: float,
    zS4: float,
    zS5: float,
) -> tuple[float, float, float, float, float, float]:
    """Return the force [N] and the elastic force as each branch has followed it [N]."""
    nu = relaxation_rate * nu_s
    zS1 = branch(zS1, elastic_force, elastic_before, nu, dt)
    zS2 = branch(zS2, elastic_force, elastic_before, 10.0 * nu, dt)
    zS3 = branch(zS3, elastic_force, elastic_before, 100.0 * nu, dt)
    zS4 = branch(zS4, elastic_force, elastic_before, 1000.0 * nu, dt)
    zS5 = branch(zS5, elastic_force, elastic_before, 10000.0 * nu, dt)
    relaxed = c_s1 * zS1 + c_s2 * zS2 + c_s3 * zS3 + c_s4 * zS4 + c_s5 * zS5
    share = MOST / max(MOST, c_s1 + c_s2 + c_s3 + c_s4 + c_s5)
    return force - relaxation_strength * share * relaxed, zS1, zS2, zS3, zS4, zS5


def _amplitude(i: int) -> Parameter:
    doc = f"fraction of the force that relaxes at nu_s times 1e{i - 1}"
    return Parameter(f"c_s{i}", "1", 0.05, 0.1, 0.0, MOST, doc, null=0.0)


EFFECT = Effect(
    name="relaxation_spectrum",
    summary="under a constant indentation the force falls further, on two or more separate time scales",
    residual="several steps in log t, in holds and sines alike",
    cites=("TiezziKao2007",),
    parameters=(
        Parameter("nu_s", "1/s", 0.01, 0.6, 3e-3, 3e-2, "slowest of the rates", transform="log"),
        *map(_amplitude, range(1, 6)),
    ),
    states=tuple(
        State(f"zS{i}", "N", f"elastic force as branch {i} has followed it", high="elastic_force")
        for i in range(1, 6)
    ),
    hooks=(hook(force),),
    confounded=("second_relaxation", "power_law_relaxation"),
    experiment="hold over three decades of time, and sines of 1 and 10 Hz",
    generalises=("second_relaxation", "power_law_relaxation"),
    expensive=True,
    trial_shapes=(("nu_s", (0.01,)),),
)
