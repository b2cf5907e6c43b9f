"""What the fingers have learned, kept in a folder from one run to the next."""

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from vegrip.estimator import ContactEstimator, EstimatorSettings, Learner, SensorNoise
from vegrip.estimator.learning import Learned, fingerprint, restored, save
from vegrip.model import ContactModel


class Memory(Protocol):
    """What the node tells its memory."""

    def look(self, finger: str, now: int) -> Mapping[str, Learned]:
        """Take note of what the estimator of ``finger`` has learned at ``now`` [ns]; return it by symbol."""

    def keep(self) -> None:
        """Put it where the next run finds it."""


class Nothing:
    """No memory."""

    def look(self, finger: str, now: int) -> Mapping[str, Learned]:  # noqa: ARG002
        """Take no note."""
        return {}

    def keep(self) -> None:
        """Keep nothing."""


class Watching:
    """Watches what the estimators learn, and forgets it when they go."""

    def __init__(self) -> None:
        self.learners: dict[str, Learner] = {}

    def estimator(
        self, finger: str, model: ContactModel, noise: SensorNoise, settings: EstimatorSettings
    ) -> ContactEstimator:
        """Return a new estimator of ``finger`` that begins with what is known of it.

        Raises:
            ConfigError: what is there does not fit the model.

        """
        found = ContactEstimator(self._known(finger, model), noise, settings)
        self.learners[finger] = Learner(found)
        return found

    def look(self, finger: str, now: int) -> Mapping[str, Learned]:
        """Take note of what is learned."""
        return self.learners[finger].look(now) if finger in self.learners else {}

    def keep(self) -> None:
        """Keep nothing."""

    def _known(self, finger: str, model: ContactModel) -> ContactModel:  # noqa: ARG002
        return model


class Folder(Watching):
    """One file per finger and model, ``FOLDER/<finger>-<fingerprint of the model>.json``."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.folder = folder

    def keep(self) -> None:
        """Write what is valid."""
        for finger, learner in self.learners.items():
            save(learner, self._file(finger, learner.model))

    def _known(self, finger: str, model: ContactModel) -> ContactModel:
        return restored(model, self._file(finger, model))

    def _file(self, finger: str, model: ContactModel) -> Path:
        return self.folder / f"{finger}-{fingerprint(model)}.json"
