"""The check page in a real browser: from a recording with a hidden effect to an adequate model, by clicks."""

import os
import shutil
from pathlib import Path

import pytest

from vegrip.identification.samples import SAMPLES

pytestmark = [pytest.mark.browser, pytest.mark.slow]

ADDRESS = r"http://127\.0\.0\.1:\d+/\?key=\S+"
SHOTS = os.environ.get("VEGRIP_SCREENSHOTS", "")


@pytest.fixture(scope="module")
def press(shared) -> Path:
    SAMPLES["press"].write(shared.folder / "press")
    return shared.folder / "press"


@pytest.fixture
def start(shared):
    return shared.start


@pytest.fixture
def known(press) -> str:
    """Name of a folder with what the first test has found; empty, and all is found anew, without it."""
    if (press.parent / "press-check").is_dir():
        shutil.copytree(press.parent / "press-check", press.parent / "known", dirs_exist_ok=True)
    return "known"


def shoot(page, name: str) -> None:
    if SHOTS:
        page.screenshot(path=f"{SHOTS}/{name}.png", full_page=True)


def test_a_hidden_effect_is_found_added_taken_back_and_saved(press, start, visit) -> None:
    server = start("check", "press", "--port", "0")
    page = visit().page
    page.goto(server.waits_for(ADDRESS))
    page.get_by_text("unexplained misfit").first.wait_for()  # fitted and compared, not yet diagnosed
    page.get_by_text("a pull that it lacks").first.wait_for()  # the worst place, in words
    page.locator("#add-adhesion:not([disabled])").wait_for()
    assert page.locator("#verdict").inner_text() == "an effect is missing"
    shoot(page, "web-check-missing")
    page.locator("#add-adhesion").click()
    page.locator("#stop").wait_for()
    page.locator("#verdict.ok").wait_for()
    assert page.locator("#verdict").inner_text() == "adequate"
    error = float(page.locator(".huge").inner_text().split()[0])
    assert 0.9 < error < 1.1
    shoot(page, "web-check")
    assert (
        "vegrip add adhesion press --model press-check/0-start.toml" in page.locator("#commands").inner_text()
    )
    page.locator("#save-name").fill("found.toml")
    page.locator("#save-name").press("Enter")
    page.get_by_text("saved as found.toml").wait_for()
    assert "adhesion" in (press.parent / "found.toml").read_text()
    page.locator("#undo").focus()
    page.keyboard.press("Enter")
    page.locator("#verdict.warn").wait_for()
    assert server.end() in (0, 130)
    page.get_by_text("The server of this page does not answer").wait_for()
    again = start("check", "press", "--port", "0")  # goes on where it was
    page.goto(again.waits_for(ADDRESS))
    page.locator("#rung-1:not([disabled])").click()
    page.locator("#verdict.ok").wait_for()


def test_a_refusal_is_shown_and_nothing_is_lost(known, start, visit) -> None:
    page = visit(viewport={"width": 390, "height": 844}).page
    page.goto(start("check", "press", "-o", known, "--port", "0").waits_for(ADDRESS))
    page.locator("#rung-0:not([disabled])").click()
    page.locator("#add-adhesion:not([disabled])").wait_for()
    page.locator("#save-name").fill("model.txt")
    page.locator("#save-name").press("Enter")
    page.get_by_text("a model file ends in .toml").wait_for()
    page.locator("#node-name").fill("nobody")
    page.locator("#node-name").press("Enter")
    page.get_by_text("there is no node 'nobody'").wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    cut = "[...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth).length"
    assert page.evaluate(cut) == 0
    page.locator("#add-guide_friction").click()
    page.locator("#stop").click()
    page.get_by_text("was stopped; what was found before is kept").wait_for()
    assert page.locator("#verdict").inner_text() == "an effect is missing"
    page.locator("#add-adhesion:not([disabled])").wait_for()


def test_episodes_are_held_back_models_compared_and_a_motion_is_exported(known, start, visit, press) -> None:
    page = visit(color_scheme="dark").page
    page.goto(start("check", "press", "-o", known, "--port", "0").waits_for(ADDRESS))
    page.locator("#rung-0:not([disabled])").click()
    page.locator("#add-adhesion:not([disabled])").wait_for()
    page.locator("#hold-back").fill("0..99")
    page.locator("#hold-back").press("Enter")
    page.get_by_text("has no episode").wait_for()
    page.locator("#hold-back:not([disabled])").fill("1,3")
    page.locator("#hold-back").press("Enter")
    page.locator("#held-error").wait_for()
    assert float(page.locator("#held-error").inner_text()) > 0.0
    page.locator("#add-adhesion:not([disabled])").wait_for()
    commands = page.locator("#commands").inner_text()
    assert "--hold-back 1,3" in commands
    assert "--episodes 1,3" in commands
    page.locator("#beside-place:not([disabled])").select_option("0")
    page.get_by_text("--versus known/0-start.toml --hold-back 1,3").wait_for()
    page.locator("#beside-place:not([disabled])").wait_for()  # judged again, on the same episodes
    page.locator("#beside th", has_text="model 0").wait_for()
    assert "vegrip compare press --model known/0-start.toml --curves --hold-back 1,3" in (
        page.locator("#commands").inner_text()
    )
    page.locator("#beside-file:not([disabled])").fill("nothing.toml")
    page.locator("#beside-file").press("Enter")
    page.get_by_text("there is no model file").wait_for()
    page.locator("#candidates").fill("adhesion,guide_friction")
    page.locator("#duration").fill("20")
    page.locator("#duration").press("Enter")
    page.locator("#motion").wait_for()
    with page.expect_download() as download:
        page.locator("#motion").click()
    from vegrip.identification.simulate import read_protocol

    download.value.save_as(press.parent / "next.toml")
    assert read_protocol(press.parent / "next.toml").duration <= 20.0
    assert "vegrip experiment press" in page.locator("#commands").inner_text()
    shoot(page, "web-check-dark")


def test_what_is_no_recording_is_refused_before_a_page_opens(start) -> None:
    program = start("check", "nothing-here")
    assert program.process.wait(120) == 3
    assert "there is no such folder" in program.text
