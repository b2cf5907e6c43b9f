"""Why a finger is commanded what it is: the parts of the force, in the order in which they arise."""

import math
from dataclasses import fields

import pytest

import vegrip
from vegrip import FingertipState, GripController
from vegrip.errors import UsageError
from vegrip.grip.force_parts import ForceParts
from vegrip.grip.safety import LimitSettings
from vegrip.grip.settings import ControlSettings
from vegrip.messages import Reason

MS = 1_000_000
FINGERS = ("thumb", "index")


def pinch(load: dict[str, float], *, max_force: float = 40.0, seconds: float = 1.0) -> GripController:
    """Return a pinch that has held its loads [N] at 3 N; they came within 0.2 s."""
    settings = ControlSettings(limits=LimitSettings(max_force=max_force))
    grip = GripController(FINGERS, model=vegrip.paper_model(9e-3), settings=settings)
    for k in range(round(seconds * 500)):
        now = (2 * k + 1) * MS
        part, noise = min(max((k - 100) / 100.0, 0.0), 1.0), 1e-4 * math.sin(7.0 * k)
        states = [
            FingertipState(
                now, name, k + 1, min(0.05 * k, 3.0) + noise, part * load[name] + noise, noise, 0.0
            )
            for name in FINGERS
        ]  # fmt: skip
        grip.step(states, now)
    return grip


def forces(parts: ForceParts) -> list[float]:
    return [getattr(parts, one.name) for one in fields(parts) if one.name != "reason"]


def test_the_thumb_is_commanded_what_the_other_needs_and_both_say_so() -> None:
    grip = pinch({"thumb": 0.5, "index": 1.0})
    thumb, index = map(grip.explain, FINGERS)
    assert index.least > thumb.least > 0.0
    assert thumb.required == pytest.approx(thumb.followed) != index.required
    assert thumb.balanced == pytest.approx(index.balanced) == pytest.approx(index.required)
    assert thumb.commanded == pytest.approx(index.commanded) == pytest.approx(index.required)
    assert index.commanded == grip.fingers["index"].command().normal_force


def test_before_a_load_the_force_of_the_close_is_kept_though_next_to_none_is_needed() -> None:
    parts = pinch({"thumb": 0.0, "index": 0.0}).explain("index")
    assert parts.kept == parts.required > 5.0 * parts.least


def test_the_largest_force_bounds_what_is_asked_for_and_is_the_reason() -> None:
    parts = pinch({"thumb": 2.0, "index": 2.0}, max_force=4.0).explain("index")
    assert parts.least > 4.0
    assert parts.followed > 4.0
    assert (parts.required, parts.commanded, parts.reason) == (4.0, 4.0, Reason.MAX_LIMIT)


def test_a_finger_at_fault_has_no_least_force_and_holds_what_it_held() -> None:
    grip = pinch({"thumb": 0.5, "index": 1.0})
    held = grip.explain("index").commanded
    grip.step([], 1_150 * MS)
    parts = grip.explain("index")
    assert math.isnan(parts.least)
    assert parts.required == parts.commanded == held
    assert parts.reason == Reason.INPUT_HOLD


def test_before_its_first_state_nothing_is_known_and_it_prints_a_line_for_each_part() -> None:
    grip = GripController(FINGERS, model=vegrip.paper_model(9e-3))
    parts = grip.explain("index")
    assert all(map(math.isnan, forces(parts)))
    assert parts.reason == Reason.INACTIVE
    lines = str(pinch({"thumb": 0.5, "index": 1.0}).explain("index")).splitlines()
    assert [line.split()[0] for line in lines] == [one.name for one in fields(parts)]
    assert lines[0].endswith(" N")
    assert lines[-1].split() == ["reason", "hold"]


def test_a_finger_that_is_not_there_is_named_in_a_sentence() -> None:
    with pytest.raises(UsageError, match="no finger 'indx'"):
        GripController(FINGERS, model=vegrip.paper_model(9e-3)).explain("indx")
