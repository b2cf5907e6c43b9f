"""The law of the search for the inputs that take longest, for every entry that is exported."""

import shutil
from pathlib import Path

import pytest

from vegrip.export import Exported


def assert_search_finds_more_than_recorded(folder: Path, exported: Exported, call: str) -> None:
    """No recorded call takes more instructions than the worst found, the first after a silence twice."""
    if shutil.which("arm-none-eabi-gcc") is None or shutil.which("qemu-system-arm") is None:
        pytest.skip("no arm-none-eabi-gcc or no qemu-system-arm")
    measured = exported.measured
    assert measured.search is not None
    assert measured.cortex_run is not None
    recorded = {name: most for name, (_, most) in measured.cortex_run.instructions.items()}
    assert measured.search.most.keys() == recorded.keys()
    assert all(measured.search.most[name] >= most for name, most in recorded.items())
    assert measured.search.most[call] > 2 * recorded[call], "the first after a silence"
    assert f"most of {measured.search.inputs} inputs" in (folder / "REPORT.md").read_text()
