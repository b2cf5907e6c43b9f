"""The README becomes the page of the package: every link is absolute, or is none."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (
    "[demo](docs/demo.md), [peer](https://example.org/x), [below](#more)\n![picture](docs/images/demo.png)\n"
)


@pytest.fixture(scope="module")
def setup() -> ModuleType:
    spec = importlib.util.spec_from_file_location("setup_of_vegrip", ROOT / "setup.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_with_a_home_relative_links_lead_there(setup: ModuleType) -> None:
    assert setup.absolute(PAGE, "https://files.example/vegrip/") == (
        "[demo](https://files.example/vegrip/docs/demo.md), [peer](https://example.org/x), [below](#more)\n"
        "![picture](https://files.example/vegrip/docs/images/demo.png)\n"
    )


def test_without_a_home_only_their_text_is_left(setup: ModuleType) -> None:
    assert setup.absolute(PAGE, "") == "demo, [peer](https://example.org/x), [below](#more)\n\n"
