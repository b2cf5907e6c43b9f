"""Short recordings of the test bench with anything hidden."""

import pytest

from tests.identification.bench import recorded
from validation.diagnosis_trials.unmodelled import EVERY
from vegrip.identification.recording import Recording


@pytest.fixture(scope="session")
def hide():
    """Give the recording in which effects (by name, with their parameters) are hidden."""

    def recording(seed: int = 0, **hidden: dict[str, float]) -> Recording:
        return recorded("+".join(hidden) or "nothing", seed, hidden, catalogue=EVERY)

    return recording
