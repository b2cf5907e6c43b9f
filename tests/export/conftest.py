"""What is exported and measured, once for all tests."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from shutil import which

import pytest

from tests.conftest import Once
from tests.export.firmware import Firmware, request_of
from vegrip.export import Exported, measure, texts, write_export


@pytest.fixture(scope="session")
def firmware(once: Once[Firmware]) -> Callable[..., Firmware]:
    def made(entry: str, precision: str = "double") -> Firmware:
        return once(f"firmware-{entry}-{precision}", partial(_written, entry, precision))

    return made


def _written(entry: str, precision: str, folder: Path) -> tuple[Path, Exported]:
    return folder, write_export(request_of(entry, precision), folder)


@pytest.fixture(scope="session")
def unmeasured(once: Once[Path]) -> Callable[[str, str], Path]:
    """The folder of an export, before any compiler has met it."""

    def made(entry: str, precision: str) -> Path:
        return once(f"texts-{entry}-{precision}", partial(_text, entry, precision))

    return made


def _text(entry: str, precision: str, folder: Path) -> Path:
    for name, text in texts.write(request_of(entry, precision, 20)).files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def host_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither a compiler for Cortex-M nor an emulator."""
    monkeypatch.setattr(measure, "which", lambda tool: None if "arm" in tool else which(tool))
