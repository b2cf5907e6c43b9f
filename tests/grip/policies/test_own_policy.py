"""A grip policy of another package, that of examples/own_policy, is found by its entry point."""

import dataclasses
import sys
import types
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.grip import policies
from vegrip.grip.node import GraspForce
from vegrip.grip.policies import find_policy, policy_names
from vegrip.grip.settings import ControlSettings, policy_settings
from vegrip.messages import FingertipState, ForceCommand

PERIOD = 2_000_000  # [ns]


EXAMPLE = Path(__file__).parents[3] / "examples" / "own_policy" / "my_policy.py"
PACKAGE = types.ModuleType("my_package.my_policy")
sys.modules[PACKAGE.__name__] = PACKAGE  # dataclasses look there
exec(compile(EXAMPLE.read_text(encoding="utf-8"), str(EXAMPLE), "exec"), PACKAGE.__dict__)  # noqa: S102
POINTS = {
    "proportional": "my_package.my_policy:POLICY",
    "broken": "no_such_package:POLICY",
    "wrong": "my_package.my_policy:Proportional",
}


@pytest.fixture(autouse=True)
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Packages that offer policies."""

    def points(group: str, name: str | None = None) -> list[EntryPoint]:
        assert group == "vegrip.policies"
        return [EntryPoint(known, target, group) for known, target in POINTS.items() if name in (None, known)]

    monkeypatch.setattr(policies, "entry_points", points)
    policies._added.cache_clear()
    yield
    policies._added.cache_clear()


def test_it_grips_with_its_own_settings(
    make_node: Callable[..., GraspForce], state: Callable[..., FingertipState]
) -> None:
    settings = build(
        ControlSettings, {"policy": "proportional", "policy_settings": {"gain": 5.0}}, "[parameters]"
    )
    node = make_node(settings=settings)
    for i in range(1, 500):
        answers = node.on_message(state(i, tangential_force_x=1.2), i * PERIOD)
        command = next(m for m in answers if isinstance(m, ForceCommand))
    assert command.normal_force == pytest.approx(6.0, rel=0.01)
    node.cleanup()
    node.parameters = dataclasses.replace(settings, policy_settings={"gain": 2.5})
    node.configure()
    for i in range(500, 1500):
        answers = node.on_message(state(i, tangential_force_x=1.2), i * PERIOD)
        command = next(m for m in answers if isinstance(m, ForceCommand))
    assert command.normal_force == pytest.approx(3.0, rel=0.01)


@pytest.mark.parametrize("name", policies.POLICIES)
def test_a_built_in_policy_has_settings_of_its_own_and_is_in_the_step(name: str) -> None:
    kind = find_policy(name)
    assert isinstance(policy_settings(build(ControlSettings, {"policy": name}, "test")), kind.settings)
    assert kind.make is None


def test_names_are_told_built_in_ones_first() -> None:
    assert policy_names() == ["margin", "constant", "cone", "elastic", "broken", "proportional", "wrong"]


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ({"policy": "proportionl"}, "there is no grip policy 'proportionl'; .*did you mean proportional"),
        ({"policy": "broken"}, "'broken' cannot be loaded from no_such_package:POLICY: No module named 'no_"),
        ({"policy": "wrong"}, "'wrong' is not a PolicyKind"),
        (
            {"policy": "proportional", "policy_settings": {"gain": -1.0}},
            "'gain' is -1; it must lie in 0 .. 100",
        ),
        ({"policy": "proportional", "policy_settings": {"gian": 1.0}}, "'gian'.*gain"),
        (
            {"policy": "margin", "policy_settings": {"gain": 1.0}},
            "are for other policies; 'margin' has the table 'grip'",
        ),
        ({"policy": "cone", "policy_settings": {"safety": -1.0}}, "'safety' is -1; it must lie in 0 .. 100"),
        ({"cone": {"safety": 1.0}}, "unknown key 'cone'"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_sentence(table: dict[str, object], sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        build(ControlSettings, table, "[parameters]")


def test_a_policy_forgets_with_each_command_that_is_not_given_by_it(
    make_node: Callable[..., GraspForce],
    state: Callable[..., FingertipState],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Four good states do not suffice; silence is noticed after 50 ms, and a command renewed after 25 ms."""
    node = make_node(settings=build(ControlSettings, {"policy": "proportional"}, "[parameters]"))
    forgets: list[int] = []
    monkeypatch.setattr(node.fingers["index"].policy, "reset", lambda: forgets.append(i))
    for i in range(1, 300):
        if not 100 <= i < 150:
            node.on_message(state(i), i * PERIOD)
        list(node.on_tick(i * PERIOD))
    assert forgets == [1, 2, 3, 4, 125, 138, 150, 151, 152, 153]
