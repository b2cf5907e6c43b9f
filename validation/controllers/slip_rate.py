"""How often a grip slips in disturbed seconds, over the probability: the table of ``grip.slip_every``.

Usage: ``python -m validation.controllers.slip_rate --seeds 40`` prints the rows of
:mod:`vegrip.grip.slip_table`.

The controller is a node with the package defaults, but for ``grip.probability``; it learns friction by
slipping, and neither shares nor probes it. Hand, drives and slip channel are those of the usual scenarios
(:mod:`.scenario`). A second is disturbed in which anything acts on the object, the lift included. Slips are
counted with half of one added (the median of a Poisson rate is near that), so that a row without a slip
claims no more than was looked at.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vegrip.trials.candidates import demo_parameters
from vegrip.trials.closed_loop import GRASPS, SAMPLING_S, Scenario, run_grip
from vegrip.trials.fronts import CLASSES, figures_of, record_of

PROBABILITIES = (0.5, 0.7, 0.8, 0.9, 0.95)
FIRST_SEED = 4000  # which nothing else was chosen on
DURATION_S = 10.0
UNSEEN_SLIPS = 0.5  # added to the slips that were counted


@dataclass(frozen=True)
class Row:
    """One probability in one grasp."""

    probability: float
    disturbed: float  # [s]
    slips: int
    force_over_least: float

    @property
    def every(self) -> float:
        """Disturbed seconds for each slip [s]."""
        return self.disturbed / (self.slips + UNSEEN_SLIPS)


def measure(grasp: str, probability: float, seeds: Sequence[int], duration: float = DURATION_S) -> Row:
    """Return the row of a ``grasp`` at a ``probability``."""
    base = demo_parameters()
    settings = replace(base, grip=replace(base.grip, probability=probability))
    records = []
    for seed in seeds:
        scenario = Scenario(seed, duration, grasp)
        run = run_grip(scenario.hand(), settings, duration)
        records.append(record_of(run, scenario.events, scenario.settings.actuator.close_time))
    acting = sum(int(np.sum(record.classes != CLASSES.index("static"))) for record in records)
    figures = figures_of(records, SAMPLING_S)
    return Row(probability, acting * SAMPLING_S, figures["slips"], figures["force_over_least"])


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the table and print it."""
    parser = argparse.ArgumentParser(prog="python -m validation.controllers.slip_rate", description=__doc__)
    parser.add_argument("--seeds", type=int, default=40, help="scenarios of each row (default 40)")
    parser.add_argument("--grasp", nargs="+", choices=tuple(GRASPS), default=tuple(GRASPS))
    given = parser.parse_args(arguments)
    if given.seeds < 1:
        parser.error("--seeds is at least 1")
    for grasp in given.grasp:
        for probability in PROBABILITIES:
            row = measure(grasp, probability, range(FIRST_SEED, FIRST_SEED + given.seeds))
            slips = f"{row.slips} slips in {row.disturbed:.0f} s, {row.force_over_least:.2f} x least"
            sys.stdout.write(f"{grasp}: ({probability:g}, {row.every:.0f}),  # {slips}\n")
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
