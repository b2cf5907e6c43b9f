"""``vegrip test-effect`` says of an effect whether it holds to the laws of every effect."""

import json
from importlib.metadata import EntryPoint

import pytest

from vegrip import cli, effects
from vegrip.effects import Effect, hook
from vegrip.parameters import Parameter


def scaled(elastic_force: float, s_f: float) -> float:
    return elastic_force * (1.0 + s_f)


def made(null: float | None) -> Effect:
    parameter = Parameter("s_f", "1", 0.1, 0.1, 0.0, 1.0, "something", null=null)
    return Effect("made", "made for a test", ("own",), (hook(scaled, stage="elastic"),), (parameter,))


SOUND, BROKEN = made(0.0), made(None)


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Effects of another package: a sound one and a broken one."""
    points = [EntryPoint(name, f"{__name__}:{name.upper()}", effects.GROUP) for name in ("sound", "broken")]
    found = {"sound": SOUND, "broken": BROKEN}
    monkeypatch.setattr(EntryPoint, "load", lambda point: found[point.name])

    def entry_points(*, name: str | None = None, **_: str) -> list[EntryPoint]:
        return [point for point in points if name in (None, point.name)]

    monkeypatch.setattr(effects, "entry_points", entry_points)
    return monkeypatch


def test_a_sound_one_holds_to_all(added: object, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["test-effect", "sound"]) == 0
    assert capsys.readouterr().out == "sound: holds to 8 laws\n"


def test_a_broken_law_is_a_sentence_and_exit_code_3(
    added: object, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["test-effect", "broken", "--json"]) == 3
    (told,) = json.loads(capsys.readouterr().out).values()
    assert "no parameter has a null value" in told["broken"][0]


def test_by_default_those_of_other_packages_are_tested(
    added: object, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["test-effect"]) == 3
    out = capsys.readouterr().out
    assert "sound: holds to 8 laws" in out
    assert "broken: breaks 2 of 8 laws" in out


def test_a_name_that_does_not_exist_is_refused_before_any_work(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["test-effect", "adhesion", "nosuch"]) in (2, 3)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "nosuch" in captured.err


def test_without_other_packages_it_says_what_to_do(
    added: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    added.setattr(effects, "entry_points", lambda **_: [])
    assert cli.main(["test-effect"]) == 2
    assert "vegrip new-effect" in capsys.readouterr().err
