"""Endpoints are opened by name, closed by ``with``, and other packages add their own."""

from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint
from typing import Any

import pytest

from tests.pair import PairEndpoint, pair
from vegrip.errors import ConfigError
from vegrip.messages import FingertipState
from vegrip.transport import open as opening
from vegrip.transport.endpoint import Endpoint
from vegrip.transport.open import Hand, open_endpoint

OTHERS: list[PairEndpoint] = []


def open_back_to_back(table: Mapping[str, Any], hand: Hand, where: str) -> Endpoint:
    """A transport of another package."""
    assert where == "open_endpoint('back_to_back')"
    assert table == {"kind": "back_to_back", "label": "a"}
    assert hand.fingers == ("thumb", "index", "middle", "ring", "little")
    ours, theirs = pair()
    OTHERS.append(theirs)
    return ours


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    points = {"back_to_back": f"{__name__}:open_back_to_back", "broken": "no_such_package:open"}

    def entry_points(group: str) -> list[EntryPoint]:
        assert group == "vegrip.transports"
        return [EntryPoint(name, target, group) for name, target in points.items()]

    def import_module(name: str) -> Any:
        if name == "no_such_package":
            raise ModuleNotFoundError(f"No module named {name!r}")
        return type("Module", (), {"open_back_to_back": staticmethod(open_back_to_back)})

    monkeypatch.setattr(opening, "entry_points", entry_points)
    monkeypatch.setattr(opening.importlib, "import_module", import_module)
    yield
    OTHERS.clear()


def test_a_can_bus_is_opened_by_kind_and_channel_and_closed_by_with() -> None:
    state = FingertipState(1_000_000, "index", 1, 2.0)
    with (
        open_endpoint("can", channel="front-door") as hand,
        open_endpoint("can", channel="front-door") as other,
    ):
        hand.send(state)
        (found,) = other.receive(timeout=60.0)
    assert isinstance(found, FingertipState)
    assert found.finger == "index"
    assert found.normal_force == pytest.approx(2.0, abs=1e-3)


def test_an_endpoint_is_closed_also_after_an_error() -> None:
    ours, theirs = pair()
    with pytest.raises(ZeroDivisionError), ours:
        raise ZeroDivisionError
    theirs.close()


def test_settings_of_a_table_and_keywords_are_the_same() -> None:
    with pytest.raises(ConfigError, match=r"open_endpoint\('can'\): unknown key 'chanel'"):
        open_endpoint("can", chanel="can0")
    with pytest.raises(ConfigError, match=r"\[transport\]: unknown key 'chanel'"):
        open_endpoint({"kind": "can", "chanel": "can0"}, Hand(("thumb",)))


@pytest.mark.usefixtures("installed")
def test_a_transport_of_another_package_is_found_by_its_entry_point() -> None:
    with open_endpoint("back_to_back", label="a") as bus:
        OTHERS[0].send(FingertipState(0, "thumb", 0))
        assert len(bus.receive(timeout=60.0)) == 1


@pytest.mark.usefixtures("installed")
def test_a_transport_that_is_not_there_or_broken_is_told_in_one_sentence() -> None:
    with pytest.raises(ConfigError, match=r"'kind' is 'canopn'; it must be one of .*back_to_back"):
        open_endpoint("canopn")
    with pytest.raises(ConfigError, match="'broken' cannot be loaded from no_such_package:open: No module"):
        open_endpoint("broken")
