"""Draw the pictures of the demonstration: ``python docs/demo_figures.py`` writes into ``docs/images/``.

It runs the demonstration for real (30 s), so the figures in the pictures are those of this machine.
"""

import shutil
import sys
import tempfile
import time
from io import StringIO
from pathlib import Path

from rich.console import Console

from vegrip.demo.command import others
from vegrip.demo.plot import picture
from vegrip.demo.run import Demo, elapsed, run
from vegrip.demo.scenario import Scenario
from vegrip.monitor import render

IMAGES = Path(__file__).parent / "images"
PICTURES = {"hand": "demo.png", "pinch": "demo-pinch.png"}
SEED, DURATION, SHOT = 0, 30.0, 17.0  # SHOT: [s] when the screen is taken


def main() -> int:
    """Run, take the screen, draw."""
    for grasp in ("hand", "pinch"):
        scenario = Scenario(SEED, DURATION, grasp)
        console = Console(record=True, width=132, file=StringIO(), force_terminal=True)
        shots: list[float] = []

        def refresh(demo: Demo, console: Console = console, shots: list[float] = shots) -> None:
            if not shots and elapsed(demo) > SHOT:
                shots.append(elapsed(demo))
                console.print(render(demo.board, time.monotonic_ns(), demo.title()))

        folder = Path(tempfile.mkdtemp())
        outcome = run(scenario, folder / "recording", refresh, print)
        courses = {"vegrip": outcome.course, **others(scenario)}
        picture(courses, scenario.events, IMAGES / PICTURES[grasp], DURATION)
        if grasp == "hand":
            console.save_svg(str(IMAGES / "demo.svg"), title="vegrip demo")
        shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
