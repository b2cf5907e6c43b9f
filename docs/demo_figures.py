"""Draw the pictures of the demonstration into docs/images: ``PYTHONPATH=. python docs/demo_figures.py``.

The screen is that of a real run (30 s) on this machine. The curves are of the same scenario in simulated
time, for all controllers, so they are the same on every machine.
"""

import shutil
import sys
import tempfile
import time
from io import StringIO
from pathlib import Path

import numpy as np
from rich.console import Console

from validation.controllers.comparison import Trial, run_course
from vegrip.demo.plot import draw_comparison
from vegrip.demo.report import run_other_controllers
from vegrip.demo.run import Demo, elapsed, run
from vegrip.runtime.monitor import render
from vegrip.trials.candidates import DEMONSTRATED, KNOBS
from vegrip.trials.closed_loop import Scenario

IMAGES = Path(__file__).parent / "images"
PICTURES = {"hand": "demo.png", "pinch": "demo-pinch.png"}
SEED, DURATION, SHOT = 0, 30.0, 17.0  # SHOT: [s] when the screen is taken


def take_the_screen(scenario: Scenario) -> None:
    """Run the demonstration and keep what the screen shows at SHOT."""
    console = Console(record=True, width=132, file=StringIO(), force_terminal=True)
    shots: list[float] = []

    def refresh(demo: Demo) -> None:
        if not shots and elapsed(demo) > SHOT:
            shots.append(elapsed(demo))
            console.print(render(demo.board, time.monotonic_ns(), demo.title(), size=(132, 50)))

    folder = Path(tempfile.mkdtemp())
    run(scenario, folder / "recording", refresh, print)
    console.save_svg(str(IMAGES / "demo.svg"), title="vegrip demo")
    shutil.rmtree(folder)


def main() -> int:
    """Take the screen of a real run, draw the simulated ones."""
    take_the_screen(Scenario(SEED, DURATION, "pinch"))
    for grasp, name in PICTURES.items():
        scenario = Scenario(SEED, DURATION, grasp)
        ours = run_course(Trial(DEMONSTRATED, SEED, DURATION, KNOBS[grasp][DEMONSTRATED], grasp))
        stated = [(time, *rows[0]) for time, rows in zip(ours.time, ours.stated, strict=True)]
        ours.friction = [  # of the thumb, whose logarithm is stated now and then
            (time, np.exp(mean), np.exp(mean) * std) for time, mean, std in stated if np.isfinite(mean)
        ]
        others = run_other_controllers(scenario, ours)
        draw_comparison({"vegrip": ours, **others}, scenario.events, IMAGES / name, DURATION)
    return 0


if __name__ == "__main__":
    sys.exit(main())
