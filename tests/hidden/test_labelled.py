"""Recordings of another simulator, named after what is hidden in them."""

from collections.abc import Callable
from pathlib import Path

import pytest

from vegrip.identification.diagnosis import diagnose
from vegrip.identification.recording import read_recording

LONG = ("adhesion", "load-dependent-friction", "second-relaxation", "sensor-lag", "series-compliance")


@pytest.mark.slow
@pytest.mark.parametrize(
    "folder", ["nothing", *(pytest.param(name, marks=pytest.mark.long) for name in LONG)]
)
def test_what_the_folder_is_named_after_is_named(folder: str, measured: Callable[[str], Path]) -> None:
    found = diagnose(read_recording(measured("hidden-effects") / folder))
    if folder == "nothing":
        assert (found.verdict, found.named) == ("adequate", [])
    else:
        assert (found.verdict, found.named) == ("named", [folder.replace("-", "_")])
        assert found.error["after"] < found.error["before"]
