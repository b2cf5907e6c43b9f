"""What is exported and measured, once for all tests."""

from collections.abc import Callable
from functools import cache

import pytest

from tests.export.firmware import Firmware
from vegrip.export import Request, write_export
from vegrip.model import paper_model

FRAMES = {"estimator": 200, "finger": 260}


@pytest.fixture(scope="session")
def firmware(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Firmware]:
    @cache
    def made(entry: str, precision: str = "double") -> Firmware:
        folder, frames = tmp_path_factory.mktemp("firmware"), FRAMES[entry]
        request = Request(paper_model(8e-3), prefix="lh", frames=frames, entry=entry, precision=precision)
        return folder, write_export(request, folder)

    return made
