"""What is exported and measured, once for all tests."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from shutil import which

import pytest

from tests.conftest import Once
from tests.export.firmware import SANITIZED, Firmware, request_of, run
from vegrip.c99 import host
from vegrip.export import Exported, measure, texts, write_export


@pytest.fixture(scope="session")
def firmware(once: Once[Firmware]) -> Callable[..., Firmware]:
    def made(entry: str, precision: str = "double") -> Firmware:
        return once(f"firmware-{entry}-{precision}", partial(_written, entry, precision))

    return made


def _written(entry: str, precision: str, folder: Path) -> tuple[Path, Exported]:
    return folder, write_export(request_of(entry, precision), folder)


@pytest.fixture
def sanitized(firmware: Callable[..., Firmware], once: Once[Path], tmp_path: Path) -> Callable[..., None]:
    """Build sources with the library of an export under sanitizers, and run that; it must end well."""

    def ends_well(entry: str, *others: str | Path) -> None:
        folder = firmware(entry)[0]

        def built(what: str, output: Path, *given: str | Path) -> Path:
            command = (str(host.compiler()), *host.EXACT, *SANITIZED, "-I.", *given, "-o", output, "-lm")
            done = run(*command, where=folder)
            assert done.returncode == 0, (what, done.stderr)
            return output

        library = once(f"sanitized-{entry}", lambda there: built(entry, there / "o", "-c", f"lh_{entry}.c"))
        done = run(built("program", tmp_path / "t", library, *others), where=folder)
        assert done.returncode == 0, done.stdout + done.stderr

    return ends_well


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
