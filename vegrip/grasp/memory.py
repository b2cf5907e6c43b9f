"""What the fingers have learned, kept in a folder from one run to the next."""

from pathlib import Path
from typing import Protocol

from vegrip.estimator import ContactEstimator, EstimatorSettings, Learner, SensorNoise
from vegrip.estimator.learning import fingerprint, restored, save
from vegrip.model import ContactModel


class Memory(Protocol):
    """What the node tells its memory."""

    def look(self, finger: str, now: int) -> None:
        """Take note of what the estimator of ``finger`` has learned at ``now`` [ns]."""

    def keep(self) -> None:
        """Put it where the next run finds it."""


class Nothing:
    """No memory."""

    def look(self, finger: str, now: int) -> None:
        """Take no note."""

    def keep(self) -> None:
        """Keep nothing."""


class Folder:
    """One file per finger and model, ``FOLDER/<finger>-<fingerprint of the model>.json``."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.learners: dict[str, Learner] = {}

    def estimator(
        self, finger: str, model: ContactModel, noise: SensorNoise, settings: EstimatorSettings
    ) -> ContactEstimator:
        """Return a new estimator of ``finger`` that begins with what was learned.

        Raises:
            ConfigError: what is there does not fit the model.

        """
        found = ContactEstimator(restored(model, self._file(finger, model)), noise, settings)
        self.learners[finger] = Learner(found)
        return found

    def look(self, finger: str, now: int) -> None:
        """Take note of what is learned."""
        if finger in self.learners:
            self.learners[finger].look(now)

    def keep(self) -> None:
        """Write what is valid."""
        for finger, learner in self.learners.items():
            save(learner, self._file(finger, learner.model))

    def _file(self, finger: str, model: ContactModel) -> Path:
        return self.folder / f"{finger}-{fingerprint(model)}.json"
