"""What the fingers have learned, kept in a folder from one run to the next."""

import contextlib
import logging
import threading
from collections.abc import Mapping
from pathlib import Path

from vegrip.clock import NS
from vegrip.estimator import ContactEstimator, EstimatorSettings, Learner, SensorNoise
from vegrip.estimator.learning import Learned, fingerprint, restored, save
from vegrip.host.realtime import SideTask
from vegrip.model import ContactModel

KEPT_EVERY = 10 * NS
"""[ns] between two writings of what is learned: so much a node that is killed forgets."""


class InMemory:
    """Observes what the estimators learn; it is lost when they go."""

    def __init__(self) -> None:
        self.learners: dict[str, Learner] = {}

    def estimator(
        self, finger: str, model: ContactModel, noise: SensorNoise, settings: EstimatorSettings
    ) -> ContactEstimator:
        """Return a new estimator of ``finger`` that begins with what is known of it."""
        found = ContactEstimator(self._known(finger, model), noise, settings)
        self.learners[finger] = Learner(found)
        return found

    def observe(self, finger: str, now: int) -> Mapping[str, Learned]:
        return self.learners[finger].look(now) if finger in self.learners else {}

    def save(self) -> None:
        """Keep nothing."""

    def _known(self, finger: str, model: ContactModel) -> ContactModel:  # noqa: ARG002
        return model


class OnDisk(InMemory):
    """One file per finger and model, ``FOLDER/<finger>-<fingerprint of the model>.json``.

    It is written at the end, and now and then beside the loop, for a node that is killed has no end.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.folder = folder
        self.writing: SideTask | None = None
        self._kept: int | None = None  # [ns] when last
        self._one_at_a_time = threading.Lock()  # never waited for by the loop

    def observe(self, finger: str, now: int) -> Mapping[str, Learned]:
        """Take note of what is learned; have it written when that is due."""
        learned = super().observe(finger, now)
        if self._kept is None or now < self._kept:
            self._kept = now
        if now - self._kept >= KEPT_EVERY and (self.writing is None or not self.writing.is_alive()):
            self._kept = now
            self.writing = SideTask(self._try_to_save)
            self.writing.start()
        return learned

    def save(self) -> None:
        with self._one_at_a_time:
            for finger, learner in tuple(self.learners.items()):
                save(learner, self._file(finger, learner.model))

    def _try_to_save(self) -> None:
        try:
            self.save()
        except OSError as error:
            logging.getLogger("vegrip.memory").warning(
                "what is learned cannot be written to %s: %s", self.folder, error.strerror
            )

    def _known(self, finger: str, model: ContactModel) -> ContactModel:
        """Return ``model`` with what is known of ``finger``; a file that cannot be used is put aside.

        A hand may be holding something: it is better served by a node that knows nothing than by none.
        """
        path = self._file(finger, model)
        try:
            return restored(model, path)
        except Exception as error:  # noqa: BLE001 (whatever is wrong with the file must not end the node)
            reason = str(error).partition("; delete ")[0] or type(error).__name__
        aside = path.with_name(f"{path.name}.damaged")
        with contextlib.suppress(OSError):
            path.replace(aside)
        logging.getLogger("vegrip.memory").error(
            "%s begins anew, and what it had learned is put aside as %s: %s", finger, aside, reason
        )
        return model

    def _file(self, finger: str, model: ContactModel) -> Path:
        return self.folder / f"{finger}-{fingerprint(model)}.json"
