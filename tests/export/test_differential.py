"""The exported C does what Python does, whatever comes: frames, times, saves and settings."""

import dataclasses
import logging
import math
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.export.differential import (
    FRAME,
    INIT,
    LOAD,
    ODD_TIMES,
    SAVE,
    SET,
    TICK,
    Attacker,
    InC,
    InPython,
    Order,
    build,
    difference,
)  # fmt: skip
from vegrip.c99 import host
from vegrip.config import declaration
from vegrip.errors import ConfigError, InputError
from vegrip.estimator.layout import FRICTION, MODE, layout_of
from vegrip.estimator.saved_numbers import SavedNumbers
from vegrip.export import Request
from vegrip.export.finger import FingerVectors, Setting, alone, record, settable
from vegrip.export.saved import HEAD, TAIL, checksum, numbers_of, resumed
from vegrip.grip.settings import ControlSettings
from vegrip.model import paper_model
from vegrip.runtime.lifecycle import describe_parameters, with_value

needs_compiler = pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
REQUEST = Request(paper_model(8e-3), frames=80, entry="finger")
FRAMES = int(os.environ.get("VEGRIP_FUZZ_C", "120"))  # `make fuzz-c` has a million
BY_NUMBA = 20_000  # frames from which on it pays to compile
SEED = int(os.environ.get("VEGRIP_FUZZ_SEED", "26"))
SETTINGS = tuple(settable())
LAYOUT = layout_of(REQUEST.model)
PLACES = LAYOUT.places()


@pytest.fixture(scope="module")
def vectors() -> FingerVectors:
    return record(REQUEST)


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(REQUEST, tmp_path_factory.mktemp("differential"))


@pytest.fixture
def python() -> InPython:
    return InPython(REQUEST, "python")


@pytest.fixture(scope="module")
def saved(vectors: FingerVectors) -> np.ndarray:
    """What a finger saves that has met all frames."""
    found = InPython(REQUEST, "python")
    for meeting in vectors.meetings:
        what = FRAME if meeting.data else TICK
        found.answer(Order(what, 0, meeting.arrival, meeting.now, meeting.data))
    return found.save(0)


@needs_compiler
def test_no_order_makes_a_difference_between_c_and_python(vectors: FingerVectors, program: Path) -> None:
    python = InPython(REQUEST, "numba" if FRAMES >= BY_NUMBA else "python")
    assert difference(python, Attacker(SEED, vectors, python), program, FRAMES) == ""
    logging.getLogger(__name__).info("%d frames: %s", FRAMES, dict(python.counts))
    for done in (("frame", True), ("set", True), ("set", False), ("load", True), ("load", False)):
        assert python.counts[done] > 0, done


@needs_compiler
@pytest.mark.parametrize("time", ODD_TIMES)
def test_no_time_overflows(time: int, vectors: FingerVectors, program: Path, python: InPython) -> None:
    orders = [Order(INIT, 0, 0, 0)]
    for meeting in vectors.meetings[:12]:
        what = FRAME if meeting.data else TICK
        orders.append(Order(what, 0, meeting.arrival, meeting.now, meeting.data))
        orders += [Order(TICK, 0, 0, time), Order(FRAME, 0, time, time, meeting.data)]
    with InC(program) as c:
        assert c.obey(orders) == [python.answer(order) for order in orders]


@pytest.mark.long
@needs_compiler
def test_a_save_with_a_number_replaced_or_a_bit_flipped_is_refused(
    program: Path, saved: np.ndarray, python: InPython
) -> None:
    rng = np.random.default_rng(SEED)
    with InC(program) as c:
        before = c.obey([Order(INIT, 0, 0, 0), Order(LOAD, 0, numbers=saved)])[-1]
        assert before[0] == 1
        for at in range(len(saved)):
            damaged = []
            for other in (1e30, -1e30, -1.9, 0.0, -0.0, 1.0, math.nan, math.inf):
                if saved[at] != other or math.copysign(1.0, other) != math.copysign(1.0, saved[at]):
                    damaged.append(saved.copy())
                    damaged[-1][at] = other
            for bit in rng.choice(64, size=6, replace=False):
                damaged.append(saved.copy())
                damaged[-1].view(np.uint64)[at] ^= np.uint64(1) << np.uint64(bit)
            refused = (0, *before[1:])
            assert set(c.obey([Order(LOAD, 0, numbers=one) for one in damaged])) == {refused}, at
            for one in damaged:
                with pytest.raises(InputError):
                    resumed(python.estimator, one)


def place_of(section: str, number: int) -> int:
    """Return where a number of the memory stands in a save."""
    places = SavedNumbers(REQUEST.model, LAYOUT).places.tolist()
    return HEAD + places.index(PLACES[section][0] + number)


ILLEGAL = {
    "friction is not a number": ("FRICTION", FRICTION.index("LN_MU"), math.nan),
    "friction is far below its bounds": ("FRICTION", FRICTION.index("LN_MU"), -60.0),
    "friction is far above its bounds": ("FRICTION", FRICTION.index("BASE_LN"), 60.0),
    "friction has no variance": ("FRICTION", FRICTION.index("VAR"), 0.0),
    "friction has a negative variance": ("FRICTION", FRICTION.index("BASE_VAR"), -0.01),
    "slips are counted below zero": ("FRICTION", FRICTION.index("EVENTS"), -1.0),
    "a counter is infinite": ("COUNTS", 0, math.inf),
    "there is no such regime": ("MODE", MODE.index("CELL"), 1e6),
    "time ran backwards": ("MODE", MODE.index("REST"), -1.0),
    "a learned parameter is beyond its bounds": ("Y", LAYOUT.learned_from, 700.0),
    "the indentation is beyond the finger": ("Y", 0, 1.0),
    "a variance is negative": ("P", LAYOUT.n + 1, -1e-12),
    "a variance is infinite": ("P", 0, math.inf),
    "a covariance is larger than its variances": ("P", 1, 1e3),
}


@needs_compiler
@pytest.mark.parametrize("case", ILLEGAL)
def test_an_illegal_number_is_refused_though_the_checksum_fits(
    case: str, program: Path, saved: np.ndarray, python: InPython
) -> None:
    section, number, value = ILLEGAL[case]
    crafted = saved.copy()
    crafted[place_of(section, number)] = value
    crafted[-TAIL] = checksum(crafted[:-TAIL])
    with InC(program) as c:
        _, before, after = c.obey([
            Order(INIT, 0, 0, 0), Order(LOAD, 0, numbers=saved), Order(LOAD, 0, numbers=crafted),
        ])  # fmt: skip
    assert before[0] == 1
    assert after == (0, *before[1:])
    known = python.estimator.memory
    with pytest.raises(InputError):
        resumed(python.estimator, crafted)
    assert np.array_equal(python.estimator.memory, known, equal_nan=True)


@needs_compiler
def test_a_save_of_firmware_is_that_of_python(program: Path, saved: np.ndarray, python: InPython) -> None:
    resumed(python.estimator, saved)
    assert np.array_equal(numbers_of(python.estimator), saved)
    with InC(program) as c:
        orders = [Order(INIT, 0, 0, 0), Order(LOAD, 0, numbers=saved), Order(SAVE, 0)]
        assert c.obey(orders) == [python.answer(order) for order in orders]


@pytest.mark.parametrize("end", ["low", "high"])
def test_the_bounds_of_settings_are_what_the_node_writes_of_parameters_at_their_bounds(end: str) -> None:
    control = REQUEST.control
    for section in ("grip", "limits", "fail_safe", "watchdog"):
        group = getattr(control, section)
        names = [one.parameter.partition(".")[2] for one in SETTINGS if one.parameter.startswith(section)]
        at_end = {name: getattr(declaration(group, name), end) for name in names}
        control = dataclasses.replace(control, **{section: dataclasses.replace(group, **at_end)})
    memory = alone(dataclasses.replace(REQUEST, control=control)).memory
    assert {one.name: memory[f"RULE_{one.name}"] for one in SETTINGS} == {
        one.name: getattr(one, end) for one in SETTINGS
    }


def tried(low: float, high: float) -> Iterator[float]:
    """Yield values at the bounds, within, just beyond, far beyond, and none at all."""
    below, above = np.nextafter(low, -math.inf), np.nextafter(high, math.inf)
    beyond = (below, above, -3.4e38, 1e30, -1.0 - abs(low), math.nan, math.inf, -math.inf)
    yield from map(float, (low, high, 0.5 * (low + high), *beyond))


@needs_compiler
@pytest.mark.parametrize("one", SETTINGS, ids=lambda one: one.name)
def test_c_refuses_what_param_set_refuses(one: Setting, program: Path) -> None:
    number = SETTINGS.index(one)
    values = [*tried(one.low, one.high), 0.2, 20.0]
    with InC(program) as c:
        for value in values:
            _, answer = c.obey([Order(INIT, 0, 0, 0), Order(SET, 0, name=number, value=value)])
            if one.name == "QUANTILE":  # the node is told a probability
                assert answer[0] == (one.low <= value <= one.high)
            else:
                assert answer[0] == is_taken(one.parameter, value / one.scale), value


def is_taken(name: str, value: float) -> bool:
    """Return whether `vegrip param set` takes a value on a running node."""
    try:
        with_value(ControlSettings(), name, value, True, "grip")
    except ConfigError:
        return False
    return True


NUMBERS = [row for row in describe_parameters(ControlSettings()) if type(row["value"]) is float]


@pytest.mark.parametrize("row", NUMBERS, ids=lambda row: row["name"])
def test_param_set_refuses_what_is_beyond_the_bounds_of_any_parameter(row: dict[str, object]) -> None:
    section, _, key = str(row["name"]).rpartition(".")
    group = getattr(ControlSettings(), section) if section else ControlSettings()
    declared = declaration(group, key)
    assert math.isfinite(declared.low)
    assert math.isfinite(declared.high)
    for value in tried(declared.low, declared.high):
        expected = declared.live and declared.low <= value <= declared.high
        if row["name"] not in {"limits.min_force", "limits.max_force"}:  # of which one bounds the other
            assert is_taken(str(row["name"]), value) == expected, value
        elif not expected:
            assert not is_taken(str(row["name"]), value), value


@needs_compiler
def test_no_least_force_above_the_largest(program: Path) -> None:
    number = {one.name: i for i, one in enumerate(SETTINGS)}
    least, most = number["MIN_FORCE"], number["MAX_FORCE"]
    steps = ((most, 5.0, 1), (least, 5.1, 0), (least, 5.0, 1), (most, 4.9, 0), (most, 5.0, 1))
    with InC(program) as c:
        orders = [Order(SET, 0, name=name, value=value) for name, value, _ in steps]
        answers = c.obey([Order(INIT, 0, 0, 0), *orders])
    assert [one[0] for one in answers[1:]] == [taken for _, _, taken in steps]


def test_the_same_memory_is_saved_as_the_same_bits_also_where_it_is_not_a_number(python: InPython) -> None:
    """Such a save is refused, but no sign of a NaN may tell one machine from another."""
    memory, place = python.ones[0].memory, PLACES["MODE"][0] + MODE.index("BEND")
    for nan in (math.nan, math.copysign(math.nan, -1.0)):
        memory.f[place] = nan
        assert python.save(0).view(np.uint64)[place_of("MODE", MODE.index("BEND"))] == 0x7FF8000000000000
    with pytest.raises(InputError):
        resumed(python.estimator, python.save(0))
