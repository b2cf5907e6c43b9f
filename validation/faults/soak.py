"""Hours of holding with one fault after another, compressed: what grows is a leak."""

import gc
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

from validation.faults.table import CASES
from validation.faults.testbed import FickleWriter, Scene

FAULT_PAUSE_S = 3.0  # [s] between two faults
WARM_SHARE = 0.5  # share of the time after which nothing may grow any more: bounded memories are full by then
PAGE = 4096  # [bytes]


@dataclass(frozen=True)
class Soak:
    """What was left after the soak."""

    duration: float  # [s] simulated
    faults: int
    objects: int  # Python objects more than after the warm-up
    memory: int  # [bytes] resident, more than after the warm-up
    slips: int
    dropped: bool
    received: int  # messages of the recorder
    lost: int  # of them not on disk


def soak(duration: float, seed: int = 0, progress: Callable[[float], object] | None = None) -> Soak:
    """Hold for ``duration`` [s] of simulated time with a random fault every few seconds."""
    with tempfile.TemporaryDirectory(prefix="vegrip-") as folder:
        return _soak(duration, Random(seed), Path(folder) / "recording", progress)  # noqa: S311 (no secret)


def _soak(duration: float, random: Random, folder: Path, progress: Callable[[float], object] | None) -> Soak:
    writer = FickleWriter(folder)
    scene = Scene(writer=writer)
    cases = [case for case in CASES if not case.slow and not case.sender_time]
    faults, start = 0, (0, 0)
    while scene.now < duration and not scene.hand_node.hand.dropped:
        scene.simulation.run_until(scene.now + FAULT_PAUSE_S)
        case = random.choice(cases)
        fault = case.make()
        fault.begin(scene)
        scene.simulation.run_until(scene.now + case.duration)
        fault.end(scene)
        faults += 1
        if start == (0, 0) and scene.now >= WARM_SHARE * duration:
            start = _footprint()
        if progress is not None:
            progress(scene.now)
    objects, memory = _footprint()
    writer.close()
    hand = scene.hand_node.hand
    received = scene.recorder.received if scene.recorder is not None else 0
    return Soak(
        duration=scene.now,
        faults=faults,
        objects=objects - start[0],
        memory=memory - start[1],
        slips=hand.slips,
        dropped=hand.dropped,
        received=received,
        lost=sum(writer.lost.values()),
    )


def _footprint() -> tuple[int, int]:
    """Return the number of Python objects and the resident memory [bytes]."""
    gc.collect()
    resident = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return len(gc.get_objects()), resident * PAGE
