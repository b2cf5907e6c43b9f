"""The controller runs commands of vegrip, keeps what they found, and goes on when one fails or is stopped."""

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from vegrip.errors import UsageError
from vegrip.identification.samples import SAMPLES
from vegrip.web import job_page
from vegrip.web.calibrate.controller import Calibrator
from vegrip.web.check.controller import Controller
from vegrip.web.check.session import Rung

PATIENCE = 120.0


def until(condition: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture
def press(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    SAMPLES["press"].write(Path("press"))
    return Path("press")


@pytest.fixture
def controller(press: Path) -> Iterator[Controller]:
    with closing(Controller(press, None, Path("press-check"))) as controller:
        yield controller


def test_what_is_stopped_leaves_what_was_found(controller: Controller) -> None:
    controller.begin()
    with pytest.raises(UsageError, match="going on"):
        controller.begin()
    controller.stop()
    until(lambda: controller.job is None)
    assert "was stopped" in controller.error
    assert controller.session.rungs == []
    assert controller.commands == ["vegrip fit press -o press-check/0-start.toml"]


def test_a_command_that_fails_says_why_and_the_check_goes_on(controller: Controller) -> None:
    controller.session.add(Rung("0-start.toml", None, None, 1.0))  # whose file is not there
    controller.judge()
    until(lambda: controller.job is None)
    assert "0-start.toml" in controller.error
    assert "Traceback" not in controller.error


def test_a_model_is_saved_under_a_new_name_only(controller: Controller) -> None:
    (controller.folder / "0-start.toml").write_text("a model")
    controller.session.add(Rung("0-start.toml", None, None, 1.0))
    controller.write_model("mine.toml")
    assert Path("mine.toml").read_text() == "a model"
    assert controller.commands == ["cp press-check/0-start.toml mine.toml"]
    for name in ("mine.toml", "", "mine.txt"):
        with pytest.raises(UsageError):
            controller.write_model(name)


def test_without_a_model_nothing_can_be_added_or_saved(controller: Controller) -> None:
    for ask in (
        lambda: controller.add("adhesion"),
        lambda: controller.write_model("mine.toml"),
        controller.judge,
    ):
        with pytest.raises(UsageError, match="no model yet"):
            ask()


def test_an_effect_is_not_added_twice_and_no_other_model_is_looked_at_than_there_is(
    controller: Controller,
) -> None:
    controller.session.add(Rung("0-start.toml", None, None, 1.0))
    controller.session.add(Rung("1-adhesion.toml", "adhesion", 0, 1.0))
    with pytest.raises(UsageError, match="has adhesion already"):
        controller.add("adhesion")
    for place in (-1, 2):
        with pytest.raises(UsageError, match="no such model"):
            controller.look_at(place)


class NoJob:
    def __init__(self, *_: object) -> None: ...
    def stop(self) -> None: ...
    def wait(self) -> None: ...


def test_a_page_is_drawn_again_once_its_command_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Drawn(Calibrator):
        def _changed(self) -> None:
            super()._changed()
            busy.append(self.job is not None)

    busy: list[bool] = []
    monkeypatch.setattr(job_page, "Job", NoJob)
    with closing(Drawn(tmp_path)) as page:
        page.begin("9 mm")
    assert busy[-1]


@pytest.mark.long
def test_a_drafted_law_is_added_by_its_file_under_its_own_name(controller: Controller) -> None:
    controller.session.add(
        Rung("0-start.toml", None, None, 4.9)
    )  # whose file is not there: no command gets far
    controller.draft()
    until(lambda: controller.job is None)
    controller.add("press-check/law_0.py")
    until(lambda: controller.job is None)
    start = "press --model press-check/0-start.toml -o press-check"
    assert controller.commands == [
        f"vegrip draft {start}/law_0.py --rival press-check/rival_0.py --curves --force",
        f"vegrip add press-check/law_0.py {start}/1-law_0.toml",
    ]
    controller.session.add(Rung("1-law_0.toml", "law_0", 0, 1.0))
    with pytest.raises(UsageError, match="has law_0 already"):
        controller.add("press-check/law_0.py")
