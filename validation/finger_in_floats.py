"""The finger in single precision against double: the same frames into both, and how far the commands part.

``python -m validation.finger_in_floats`` takes the recordings of
:mod:`validation.compiled_finger`: a hand in a closed loop, its states made hostile, and a pinch under
the faults of :mod:`validation.faults`. What is judged must not depend on the precision: the condition
of every finger after every event, counts of faults, number and time of every command. Forces and reasons
differ; the largest difference of a force is that of a ramp that begins one command earlier or later.
"""

import argparse
import struct
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from validation.compiled_finger import Answers, Log, Replay, hostile, record
from validation.faults.table import CASES

NUMBERED: Final = slice(2, 12)
"""Bytes of a command that must be the same: counter, version, time."""
FORCE_AT: Final = 12
REASON_AT: Final = 20
HAND_S: Final = 35.0  # [s] 35 000 frames
SEEDS: Final = 20
QUICK_CASES: Final = 5


@dataclass(frozen=True)
class Parted:
    """What single precision changed in the answers to one log."""

    commands: int
    judged_otherwise: int
    """Events after which a condition differs, and counts that differ; commands of one alone."""
    forces: np.ndarray  # [N] differences, one for each command
    reasons: int  # commands with another reason

    @property
    def largest(self) -> float:
        """Largest difference of a force [N]."""
        return float(self.forces.max(initial=0.0))

    @property
    def usual(self) -> float:
        """99 of 100 differences are below this one [N]."""
        return float(np.quantile(self.forces, 0.99)) if self.forces.size else 0.0


def parted(log: Log) -> Parted:
    """Let both precisions meet a log."""
    double, single = Replay(log, "c").run(), Replay(log, "c-float").run()
    pairs = list(zip(double.commands, single.commands, strict=False))
    return Parted(
        len(pairs),
        _judged_otherwise(double, single),
        np.array([abs(_force(a) - _force(b)) for (_, a), (_, b) in pairs]),
        sum(a[REASON_AT] != b[REASON_AT] for (_, a), (_, b) in pairs),
    )


def _judged_otherwise(double: Answers, single: Answers) -> int:
    pairs = zip(double.conditions, single.conditions, strict=True)
    found = sum(a != b for a, b in pairs) + abs(len(double.commands) - len(single.commands))
    found += sum(
        (a_id, a[NUMBERED]) != (b_id, b[NUMBERED])
        for (a_id, a), (b_id, b) in zip(double.commands, single.commands, strict=False)
    )
    counts = ((one.faults, one.lost, one.rejected) for one in (double, single))
    return found + (next(counts) != next(counts))


def _force(command: bytes) -> float:
    force: float = struct.unpack_from("<f", command, FORCE_AT)[0]
    return force


def logs(*, quick: bool) -> Iterator[tuple[str, Log]]:
    """Yield what both meet, by name."""
    cases = [case for case in CASES if not case.slow]
    hand = record(None, 2.0 if quick else HAND_S, "hand")
    yield "a hand, undisturbed", hand
    short = hand if quick else record(None, 10.0, "hand")
    for seed in range(2 if quick else SEEDS):
        yield f"a hand, hostile states, seed {seed}", hostile(short, seed)
    for case in cases[:: max(1, len(cases) // QUICK_CASES)] if quick else cases:
        yield case.name, record(case, 0.0)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line for each log; return 4 when something was judged otherwise, else 0."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few and short recordings")
    chosen = parser.parse_args(arguments)
    sys.stdout.write(f"{'commands':>8} {'otherwise':>9} {'99 %':>8} {'largest':>8} {'reasons':>8}\n")
    judged = 0
    for name, log in logs(quick=chosen.quick):
        one = parted(log)
        judged += one.judged_otherwise
        share = 100.0 * one.reasons / max(1, one.commands)
        sys.stdout.write(
            f"{one.commands:8} {one.judged_otherwise:9} {1e3 * one.usual:5.2f} mN {1e3 * one.largest:5.1f} mN"
            f" {share:6.2f} %  {name}\n"
        )
        sys.stdout.flush()
    sys.stdout.write(f"{judged} judged otherwise\n")
    return 4 if judged else 0


if __name__ == "__main__":
    sys.exit(main())
