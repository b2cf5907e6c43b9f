"""The live page in a real browser, with a simulated hand and its controller."""

import os
import re
import signal
from pathlib import Path

import pytest

pytestmark = pytest.mark.browser

HAND = Path(__file__).parent / "hand.toml"
ADDRESS = r"http://127\.0\.0\.1:\d+/\?key=\S+"
ALIVE = "button.finger:not(.stale) .big"
SMALL = {"width": 900, "height": 700}  # two pages are drawn at once, without a graphics card
SHOTS = os.environ.get("VEGRIP_SCREENSHOTS", "")


@pytest.fixture(scope="module")
def served(shared):
    """A hand and a server for all tests of this file; a test leaves both as it found them."""
    shared.start("launch", str(HAND))
    return shared.start("monitor", "--web", "--port", "0")


@pytest.fixture
def address(served) -> str:
    return served.waits_for(ADDRESS)


@pytest.fixture
def grasp_force(shared, monkeypatch):
    """Return a function that finds the process of the controller."""
    from vegrip.runtime.registry import find_node

    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", shared.runtime)
    return lambda: find_node("grasp_force").pid


def shoot(page, name: str, *, whole: bool = True) -> None:
    """Keep a picture of the page for the documents, when they are being made."""
    if SHOTS:
        page.screenshot(path=f"{SHOTS}/{name}.png", full_page=whole)


def test_without_a_node_the_page_says_so_and_shows_the_hand_as_it_comes(start, visit) -> None:
    page = visit().page
    page.goto(start("monitor", "--web", "--port", "0").waits_for(ADDRESS))
    page.get_by_text("No node runs on this machine").wait_for()
    hand = start("launch", str(HAND))
    page.wait_for_selector(ALIVE)
    assert page.locator("button.finger").count() == 5
    assert not page.locator("#empty").is_visible()
    assert hand.process.poll() is None


def test_every_finger_shows_margin_command_surface_and_pressure_with_units(address, visit, until) -> None:
    page = visit(color_scheme="light").page
    page.goto(address)
    page.wait_for_selector(ALIVE)
    whole = "f.surface && f.load && f.margin.wanted && f.margin.bound != null"
    until(page, f"Object.values(vegrip.now.fingers).every(f => {whole})")
    for i in range(5):
        card = page.locator("button.finger").nth(i)
        assert re.search(r"-?\d+\.\d\d ≥ -?\d+\.\d\d, sure to 95 %", card.inner_text())
        assert re.search(r"command\s+\d+\.\d\d N", card.inner_text())
        assert "0.15" in card.inner_text()  # the wanted margin
    texts = page.locator("#surface").inner_text() + page.locator("#pressure").inner_text()
    for label in ("tangential force [N]", "torque [N mm]", "distance from the centre [mm]", "pressure [kPa]"):
        assert label in texts
    labels = " ".join(page.locator("#nodes th").all_inner_texts())
    assert "p50 / p99 / max [ms]" in labels
    if SHOTS:
        until(
            page, "vegrip.columns.thumb.filter(column => column[2] != null).length >= 600"
        )  # 24 s of margin
    shoot(page, "web-live")


def test_the_load_moves_and_the_plots_go_on(address, visit, until) -> None:
    page = visit(color_scheme="dark").page
    page.goto(address)
    page.wait_for_selector(ALIVE)
    before = page.evaluate("vegrip.now.time")
    drawn = page.evaluate("document.querySelector('#surface').innerHTML")
    until(page, f"vegrip.now.time > {before} + 1")
    assert page.evaluate("document.querySelector('#surface').innerHTML") != drawn
    assert page.locator("#plots canvas").count() == 5
    if SHOTS:
        until(
            page, "vegrip.columns.thumb.filter(column => column[2] != null).length >= 600"
        )  # 24 s of margin
    shoot(page, "web-live-dark")


def test_fingers_are_chosen_and_parameters_opened_by_keys_alone(address, visit, until) -> None:
    page = visit().page
    page.goto(address)
    page.wait_for_selector(ALIVE)
    page.keyboard.press("3")
    until(page, "document.querySelector('#plots-title').textContent.startsWith('middle')")
    assert page.locator("button.finger").nth(2).get_attribute("aria-pressed") == "true"
    page.keyboard.press("p")
    page.locator("#node-dialog[open] table").wait_for()
    page.keyboard.press("Escape")
    until(page, "!document.querySelector('#node-dialog').open")
    for _ in range(30):  # from the first element to a finger, as the tab key goes
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.classList.contains('finger')"):
            break
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    until(page, "document.querySelector('#plots-title').textContent.startsWith('index')")


def test_a_parameter_is_set_within_its_bounds_and_refused_beyond(address, visit, until) -> None:
    page = visit().page
    page.goto(address)
    page.wait_for_selector(ALIVE)
    page.locator("button[data-node='/grasp_force']").click()
    field = page.locator("input[data-parameter='grip.wanted_margin']")
    field.fill("0.4")
    field.press("Enter")
    page.get_by_text("grip.wanted_margin is 0.4").wait_for()
    assert "vegrip param set /grasp_force grip.wanted_margin 0.4" in page.locator("dialog pre").inner_text()
    fixed = page.locator("dialog tr", has_text="fixed while running")
    assert fixed.count() > 0
    assert fixed.locator("input, select").count() == 0
    shoot(page, "web-parameters", whole=False)
    field.fill("7")
    field.press("Enter")
    page.locator("dialog .say.bad").wait_for()
    assert "0.9" in page.locator("dialog .say.bad").inner_text()  # the bound
    assert field.input_value() == "0.4"
    field.fill("0.15")
    field.press("Enter")
    page.get_by_text("grip.wanted_margin is 0.15").wait_for()


def test_a_node_is_deactivated_only_when_asked_twice_and_activated_again(address, visit, until) -> None:
    page = visit().page
    page.goto(address)
    page.wait_for_selector(ALIVE)
    page.locator("button[data-node='/grasp_force']").click()
    page.locator("button[data-transition='deactivate']").click()
    page.get_by_text("Press again to do it").wait_for()
    assert page.evaluate("vegrip.now.nodes['/grasp_force'].state") == "active"
    page.locator("button[data-transition='deactivate']").click()
    page.get_by_text("the node is inactive").wait_for()
    page.locator("button[data-transition='activate']").click()
    page.get_by_text("the node is active").wait_for()
    until(page, "vegrip.now.nodes['/grasp_force'].state === 'active'")


def test_the_dialog_follows_what_another_does_to_the_node(address, visit, until) -> None:
    page, other = visit(viewport=SMALL).page, visit(viewport=SMALL).page
    for one in (page, other):
        one.goto(address)
        one.wait_for_selector(ALIVE)
        one.locator("button[data-node='/grasp_force']").click()
    for _ in range(2):
        other.locator("button[data-transition='deactivate']").click()
    page.locator("button[data-transition='activate']").click()  # offered here as well
    other.locator("button[data-transition='deactivate']").wait_for()
    until(page, "vegrip.now.nodes['/grasp_force'].state === 'active'")


def test_a_node_that_dies_is_shown_as_old_and_again_as_live_when_it_is_back(
    address, visit, until, grasp_force
) -> None:
    page = visit().page
    page.goto(address)
    page.wait_for_selector(ALIVE)
    os.kill(grasp_force(), signal.SIGSTOP)
    page.locator("button.finger.stale").first.wait_for()
    page.get_by_text("/grasp_force says nothing").first.wait_for()
    assert "no news for" in page.locator("button.finger").first.inner_text()
    shoot(page, "web-stale")
    os.kill(grasp_force(), signal.SIGKILL)  # the launcher starts it again
    page.wait_for_selector(ALIVE)
    until(page, "!vegrip.now.alarms.some(a => a.text.includes('says nothing'))")


def test_when_the_server_goes_the_page_says_so_and_keeps_what_it_has(served, shared, visit) -> None:
    server = shared.start("monitor", "--web", "--port", "0")
    page = visit().page
    page.goto(server.waits_for(ADDRESS))
    page.wait_for_selector(ALIVE)
    assert server.end() in (0, 130)
    page.get_by_text("what is shown is old").wait_for()
    assert page.locator("body.gone").count() == 1
    assert page.locator("button.finger").count() == 5


@pytest.mark.parametrize("width", [390, 1280, 1920])
def test_nothing_is_cut_off_whatever_the_width(width: int, address, visit) -> None:
    page = visit(viewport={"width": width, "height": 900}).page
    page.goto(address)
    page.wait_for_selector(ALIVE)
    page.locator("#model .chip").evaluate(
        "chip => { chip.textContent = 'the model does not explain tangential force x in deep hold'; }"
    )
    page.locator("#nodes td:last-child").last.evaluate(
        "cell => { cell.innerHTML = 'lost 230327, overrun 12'; }"
    )
    page.evaluate(
        """for (const card of document.querySelectorAll('.finger')) {
             card.querySelector('.status').innerHTML = '<span class="chip bad">no input of late</span>';
             card.querySelector('.big').innerHTML = '0.95 <small>its bound is not known yet</small>';
             if (card.scrollWidth > card.clientWidth) throw Error('a finger is cut');
           }
           if (document.documentElement.scrollWidth > innerWidth) throw Error('the page is wider');"""
    )
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    cut = "[...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth).length"
    assert page.evaluate(cut) == 0
    if width == 390:
        shoot(page, "web-narrow")


def test_a_running_node_is_recorded_and_its_model_checked(served, shared, visit, until) -> None:
    page = visit().page
    page.goto(served.waits_for(ADDRESS))
    page.wait_for_selector(ALIVE)
    check = shared.start("check", "--node", "grasp_force", "--seconds", "3", "--port", "0")
    page.goto(check.waits_for(ADDRESS))
    page.locator(
        "#verdict, .alarms li"
    ).first.wait_for()  # what a grasp of 3 s tells, or why it tells nothing
    assert "vegrip fit live/" in page.locator("#commands").inner_text()
    from vegrip.identification.recording.session import read_fingers

    fingers = read_fingers(shared.folder / "live", announce=False)
    assert set(fingers) == {"thumb", "index", "middle", "ring", "little"}
    assert all(recording.fingertip.radius == 9e-3 for recording in fingers.values())
    assert check.end() in (0, 130)


def test_two_people_see_the_same_and_choose_for_themselves(address, visit, until) -> None:
    one, other = visit(viewport=SMALL).page, visit(viewport=SMALL).page
    for page in (one, other):
        page.goto(address)
        page.wait_for_selector(ALIVE)
    other.keyboard.press("2")
    until(other, "document.querySelector('#plots-title').textContent.startsWith('index')")
    assert one.locator("#plots-title").inner_text().lower().startswith("thumb")


def test_without_the_key_nothing_is_shown(address, visit) -> None:
    page = visit().page
    answer = page.context.request.get(address.split("?")[0])
    assert answer.status == 403
    assert "key" in answer.text()
    assert page.context.request.get(address.split("?")[0] + "live").status == 403
