"""How experiments do on pairs of effects that are hard to tell apart: promised and achieved.

``python -m validation.experiment_pairs`` simulates for each pair a recording of the standard
protocol with the first effect at a share of its declared size, fits both to it, and finds the experiment that
tells them apart; then it simulates that experiment several times under either truth, and prints expectation
and outcome.
"""

import argparse
import math
import sys
from dataclasses import replace

import numpy as np

from vegrip.effects import effect
from vegrip.identification.experiment.design import Design, design
from vegrip.identification.experiment.design_space import RigLimits, complete_limits, limits_of
from vegrip.identification.experiment.hypotheses import Hypotheses, hypotheses_of, measure_separation
from vegrip.identification.fit import fit
from vegrip.identification.recording import Recording
from vegrip.identification.simulate import simulate
from vegrip.identification.simulate.protocol import standard
from vegrip.model import ContactModel, paper_model

TIP_RADIUS_M = 8e-3  # [m]
PRESSES = 11  # episodes of the standard protocol without slip
PAIR_NOISE = {"normal_force": 0.01, "displacement": 5e-6}
PAIRS = (
    ("second_relaxation", "power_law_relaxation", 0.3),
    ("series_compliance", "layer_over_core", 0.3),
    ("series_compliance", "nonseparable_relaxation", 0.5),
    ("poroelastic_drainage", "nonseparable_relaxation", 0.5),
    ("poroelastic_drainage", "series_compliance", 0.5),
    ("mullins_softening", "permanent_set", 0.3),
    ("mullins_softening", "displacement_backlash", 0.3),
    ("adhesion", "layer_over_core", 0.5),
)
"""Truth of the recording, its rival, and the truth's share of its declared size."""


def recorded(model: ContactModel, name: str, share: float) -> Recording:
    """Return a recording with an effect at a share of its declared size."""
    amount = next(p for p in effect(name).parameters if p.null is not None)
    null = amount.null or 0.0
    size = amount.default if amount.default != amount.null else null + amount.std
    truth = model.with_effect(effect(name)).with_value(amount.symbol, null + share * (size - null))
    whole = standard(truth)
    presses = replace(whole, episodes=whole.episodes[:PRESSES], notes=())
    return simulate(truth, presses, sensors=PAIR_NOISE, rate=100.0)


def planned(
    model: ContactModel, one: str, other: str, share: float, duration: float
) -> tuple[Hypotheses, Design]:
    """Return the contest of a pair and the experiment that was found for it."""
    recording = recorded(model, one, share)
    contest = hypotheses_of(fit(recording), [one, other])
    limits = complete_limits(RigLimits(duration=duration), limits_of(recording))
    return contest, design(contest, limits, is_thorough=False)


def main(arguments: list[str] | None = None) -> int:
    """Print a line for each pair and direction."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--duration", type=float, default=90.0, help="longest experiment [s]")
    given = parser.parse_args(arguments)
    model = paper_model(TIP_RADIUS_M)
    print(f"{'truth':24s}{'rival':26s}{'expected':>9s}{'achieved':>16s}  experiment")  # noqa: T201
    for one, other, share in PAIRS:
        contest, found = planned(model, one, other, share, given.duration)
        first = found.tried[0]
        assumed = ", ".join(contest.assumed)
        runs = [measure_separation(contest, first.protocol, seed) for seed in range(1, given.seeds + 1)]
        for (truth, rival), nats in first.separation.pairs.items():
            got = [run[truth, rival] for run in runs]
            spread = float(np.std(got, ddof=1)) if len(got) > 1 else math.nan
            what = f"{first.item}, {first.protocol.duration:.0f} s" + (
                f" (x {first.times})" if first.times > 1 else ""
            )
            what += "" if found.best is not None else " - shows nothing"
            what += f" [{assumed} at its declared size]" if assumed else ""
            print(f"{truth:24s}{rival:26s}{nats:9.1f}{np.mean(got):9.1f} +-{spread:5.1f}  {what}", flush=True)  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
