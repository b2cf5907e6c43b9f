"""The calibration page in a real browser: a trial that is done wrong, the remedy, and the next."""

import os
from pathlib import Path

import pytest

pytestmark = [pytest.mark.browser, pytest.mark.slow]

ADDRESS = r"http://127\.0\.0\.1:\d+/\?key=\S+"
SHOTS = os.environ.get("VEGRIP_SCREENSHOTS", "")
SEED = 4


def record(folder: Path, trial: Path) -> None:
    """Do what the file of motion says with a fingertip that the page does not know."""
    from vegrip.identification.calibration.trials import Trial, practice_tip, practise
    from vegrip.identification.recording import write_recording
    from vegrip.identification.simulate import read_protocol

    write_recording(practise(Trial("", read_protocol(trial), ()), practice_tip(SEED)), folder)


def test_a_new_fingertip_is_guided_from_the_first_press_to_the_next_trial(world, visit) -> None:
    from vegrip.identification.calibration.trials import practice_tip

    server = world.start("calibrate", "tip", "--web", "--port", "0")
    page = visit(color_scheme="light").page
    page.goto(server.waits_for(ADDRESS))
    page.locator("#radius").fill("a few")
    page.locator("#radius").press("Enter")
    page.get_by_text("give a length like '8 mm'").wait_for()
    page.locator("#radius:not([disabled])").fill(f"{1e3 * practice_tip(SEED).radius:.3g} mm")
    page.locator("#radius").press("Enter")
    page.get_by_text("nothing is known yet").wait_for()
    page.locator("#trial-recording:not([disabled])").fill("nowhere")
    page.locator("#trial-recording").press("Enter")
    page.get_by_text("there is no such folder").wait_for()
    record(world.folder / "pressed", world.folder / "tip" / "next.toml")
    page.locator("#trial-recording:not([disabled])").fill("pressed")
    page.locator("#kind").select_option("slide")  # it is none
    page.locator("#trial-recording").press("Enter")
    page.get_by_text("record again: it slides in").wait_for()
    page.locator("#trials button:not([disabled])").click()  # drop
    page.get_by_text("nothing is known yet").wait_for()
    page.locator("#trial-recording:not([disabled])").fill("pressed")
    page.locator("#trial-recording").press("Enter")
    page.get_by_text("next: hold").first.wait_for()
    assert "known" in page.locator("tr", has_text="K").first.inner_text()
    shown = page.locator("#commands").inner_text()
    assert "vegrip calibrate tip --take pressed --kind press" in shown
    assert "nowhere" not in shown  # what was refused did nothing
    assert "a few" not in shown
    if SHOTS:
        page.screenshot(path=f"{SHOTS}/web-calibrate.png", full_page=True)
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.locator("#end:not([disabled])").wait_for()
    assert server.end() in (0, 130)
