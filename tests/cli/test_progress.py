"""Long work shows itself on standard error: reading, and the compiler's first run."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from vegrip import compiled
from vegrip.cli import _terminal as _progress
from vegrip.compiling import SENTENCE
from vegrip.model import cache

KERNEL = "import numba\n\n\ndef f(x):\n    return x + {number}.0\n\n\nf = numba.njit(cache=True)(f)\n"


def test_the_first_compiling_says_so_and_the_cache_is_silent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("VEGRIP_CACHE", str(tmp_path))
    monkeypatch.setattr(compiled.announcer, "said", False)
    module = cache.load(KERNEL.format(number=7))
    with _progress.progress("fit"):
        assert module.f(1.0) == 8.0
        assert module.f(2.0) == 9.0
    assert capsys.readouterr().err.splitlines() == [f"fit: {SENTENCE}"]


def test_compiling_that_takes_long_says_how_far_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    announcer = compiled.Announcer()
    for name in ("said", "functions", "_compiled", "_since", "_reported"):
        monkeypatch.setattr(compiled.announcer, name, getattr(announcer, name))
    monkeypatch.setattr(compiled, "NEWS_PERIOD_S", 0.0)
    monkeypatch.setenv("VEGRIP_CACHE", str(tmp_path))
    called = "import numba\n\n\ndef g(x):\n    return 2.0 * x\n\n\ng = numba.njit(g)\n"
    module = cache.load(called + "\n\ndef f(x):\n    return g(x) + g(1)\n\n\nf = numba.njit(cache=True)(f)\n")
    with _progress.progress("fit"):
        assert module.f(1.0) == 4.0
    first, *rest = capsys.readouterr().err.splitlines()
    assert first == f"fit: {SENTENCE}"
    assert [re.sub(r"\d+ s so far", "0 s so far", line) for line in rest] == [
        "fit: compiling g: 0 of at most 2 functions are done, 0 s so far",
        "fit: compiling g: 1 of at most 2 functions are done, 0 s so far",
    ]


def test_of_modules_that_were_not_generated_nobody_knows_how_many_functions_will_compile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    announcer = compiled.Announcer()
    for name in ("said", "functions", "_compiled", "_since", "_reported"):
        monkeypatch.setattr(compiled.announcer, name, getattr(announcer, name))
    monkeypatch.setattr(compiled, "NEWS_PERIOD_S", 0.0)
    monkeypatch.setenv("VEGRIP_CACHE", str(tmp_path))
    functions = [made_by_hand(number) for number in range(3)]
    with _progress.progress("hand"):
        for function in functions:
            assert function(1) == 2
    _, *rest = capsys.readouterr().err.splitlines()
    assert [sentence.rpartition(",")[0] for sentence in rest] == [
        "hand: compiling twice: 1 compiled before it",
        "hand: compiling twice: 2 compiled before it",
    ]


def made_by_hand(number: int) -> Callable[[int], int]:
    """Return a function that seems to be of a module of vegrip itself."""

    def twice(x: int) -> int:
        return 2 * x

    twice.__module__ = f"vegrip.virtual.kernels{number}"
    made: Callable[[int], int] = compiled.load_numba().njit(twice)
    return made


def test_rows_are_counted_once_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(_progress.time, "monotonic", lambda: now[0])
    told: list[str] = []
    tell = _progress.counted(told.append)
    for rows in range(0, 1_000_000, 20_000):
        now[0] += 0.125
        tell(rows)
    assert told[0] == "140 000 rows"
    assert len(told) == 6


def test_a_count_is_told_once_a_second_however_often_it_grows(monkeypatch):
    now, told = [0.0], []
    monkeypatch.setattr(_progress.time, "monotonic", lambda: now[0])
    report = _progress.counted(told.append, "states")
    for tick in range(300):
        now[0] = tick / 100
        report(10 * tick)
    assert told == ["1 000 states", "2 000 states"]
