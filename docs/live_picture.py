"""Film the live page while a simulated hand holds a glass that is filled and gets wet.

``python docs/live_picture.py`` writes ``docs/images/live.webp``; it takes a minute and needs Chromium.
"""

import io
import shutil
import sys
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import sync_playwright

from validation.controllers.node_loop import NodeLoop
from vegrip.clock import NS
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import estimator_factory
from vegrip.messages import Lifecycle, Message, NodeStatus
from vegrip.runtime.monitor import Board
from vegrip.trials.candidates import demonstrated_parameters
from vegrip.trials.closed_loop import Scenario
from vegrip.virtual import Disturbance, HandSettings
from vegrip.virtual.disturbance import AddedMass, Wetting
from vegrip.web.live.stream import FedPage
from vegrip.web.live.view import LiveView

PICTURE = Path(__file__).parent / "images" / "live.webp"
DURATION, SHOWN_FROM = 22.0, 5.0  # [s] of simulated time
WANTED = 0.3  # [-] margin
FRICTION = 0.8  # [-] of the dry glass
FILLED, WET = AddedMass(7.0, 30.0, 0.15), Wetting(13.0, 6.0, 0.6)
NODE = "/grasp_force"
COLUMN, COLUMNS = 0.04, 6  # [s] between two events of the page, events between two pictures
WINDOW, WIDTH = {"width": 1180, "height": 1040}, 900  # [pixels]

HEAD = """
<div style="display:flex;align-items:center;gap:18px;padding:10px 22px;font:600 22px DejaVu Sans,sans-serif">
<svg width="54" height="64" viewBox="0 0 54 64"><path d="M8 3 L13 61 H41 L46 3" fill="#ffffff" stroke="#456"
 stroke-width="3"/><path d="M{x} {y} L14.5 58 H39.5 L{X} {y} Z" fill="#9cc9ea"/>
<g fill="#1b76b8" opacity="{drops}">
<circle cx="5" cy="22" r="3.4"/><circle cx="3" cy="38" r="2.6"/><circle cx="50" cy="28" r="3.4"/>
<circle cx="51" cy="45" r="2.6"/><circle cx="8" cy="52" r="3"/></g></svg><span>{said}</span></div>
"""


@dataclass(frozen=True)
class Glass(Scenario):
    """A glass in five fingers."""

    @property
    def settings(self) -> HandSettings:
        """The hand, with the friction of dry glass."""
        hand = super().settings
        return replace(hand, tip=replace(hand.tip, friction=FRICTION))

    @property
    def events(self) -> tuple[Disturbance, ...]:
        """What happens to it."""
        return (FILLED, WET)


class Stage(FedPage):
    """The live page of what happens in simulated time."""

    def __init__(self, wanted_margin: float) -> None:
        super().__init__(wanted_margin, port=0)
        self.view = LiveView(Board(0))

    def show(self, messages: Iterable[Message], now: int) -> None:
        """Show what happened up to ``now`` [ns]."""
        for message in messages:
            self.view.receive(message, now, NODE)
        self.add_event(now, lambda _: self._wanted)


class Overheard(GraspForce):
    """The node, and all that it hears and says."""

    messages: list[Message]

    def on_message(self, message: Message, now: int) -> Iterable[Message]:
        """Keep question and answers."""
        answers = list(super().on_message(message, now))
        self.messages += [message, *answers]
        return answers

    def on_tick(self, now: int) -> Iterable[Message]:
        """Keep the answers."""
        answers = list(super().on_tick(now))
        self.messages += answers
        return answers


def head(time: float) -> str:
    """Return the glass at ``time`` [s] and what is done to it."""
    filled = min(max((time - FILLED.start) / (0.15 * FILLED.duration), 0.0), 1.0)
    friction = (
        WET.acting((time - WET.start) / WET.duration) if WET.start < time < WET.start + WET.duration else None
    )
    wet = 0.0 if friction is None else (1.0 - friction.friction) / (1.0 - WET.friction)
    said = "A simulated hand holds an empty glass"
    if time > FILLED.start:
        said = "The glass is filled: 150 g more" if filled < 1.0 else "The glass is full"
    if friction is not None:
        said = "The glass gets wet: friction falls by 40 %"
    elif time > WET.start:
        said = "The glass is dry again"
    level = 58.0 - 44.0 * filled
    side = 14.5 - (58.0 - level) * 5.0 / 58.0
    return HEAD.format(x=side, X=54.0 - side, y=level, drops=wet, said=said)


def film(stage: Stage, loop: NodeLoop, node: Overheard, browser: Any) -> list[Image.Image]:
    """Return the pictures of the page."""
    page = browser.new_context(viewport=WINDOW, bypass_csp=True, color_scheme="light").new_page()
    page.goto(stage.address)
    page.evaluate("document.body.prepend(document.createElement('div'))")
    pictures = []
    for i in range(1, round(DURATION / COLUMN) + 1):
        now = round(i * COLUMN * NS)
        node.messages = [NodeStatus(now, NODE, i, Lifecycle.ACTIVE)]
        loop.run(i * COLUMN)
        stage.show(node.messages, now)
        if i * COLUMN < SHOWN_FROM or i % COLUMNS:
            continue
        page.evaluate("html => { document.body.firstChild.innerHTML = html }", head(i * COLUMN))
        while page.evaluate("vegrip.now?.time ?? 0") < i * COLUMN - 1e-6:
            page.wait_for_timeout(10)
        page.wait_for_timeout(120)  # the page draws its curves at most so often
        shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        size = (WIDTH, round(shot.height * WIDTH / shot.width))
        pictures.append(shot.resize(size, Image.Resampling.LANCZOS))
    return pictures


def main() -> int:
    """Hold the glass, film the page, write the moving picture."""
    scenario = Glass(0, DURATION, relaxes_slowly=False)
    parameters = demonstrated_parameters(scenario.grasp)
    parameters = replace(parameters, grip=replace(parameters.grip, wanted_margin=WANTED))
    fingers = scenario.settings.fingers
    node = Overheard(
        "grasp_force", fingers, estimator_factory(parameters, fingers, "grasp_force"), parameters
    )
    loop = NodeLoop(scenario.hand(), node)
    with closing(Stage(parameters.grip.wanted_margin)) as stage, sync_playwright() as playwright:
        chromium = shutil.which("chromium")
        first, *rest = film(
            stage, loop, node, playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        )
    period = round(1e3 * COLUMN * COLUMNS)  # [ms]
    first.save(PICTURE, save_all=True, append_images=rest, duration=period, loop=0, quality=50, method=6)
    print(f"{PICTURE}: {1 + len(rest)} pictures, {PICTURE.stat().st_size / 1e6:.1f} MB")  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
