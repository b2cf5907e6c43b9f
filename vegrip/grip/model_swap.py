"""A new model for a running node: estimators are built beside the loop and take over when they know as much.

The old ones go on meanwhile, so no command is late or missing. A model that cannot be used is reported in the
log and counted, and the old one stays.
"""

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from vegrip.errors import ModelError
from vegrip.grip.compiled import FingerKernels
from vegrip.grip.estimator_protocol import Estimator
from vegrip.grip.finger import GraspFinger
from vegrip.host.realtime import SideTask
from vegrip.messages import FingertipState
from vegrip.model import ContactModel
from vegrip.model.file import model_text
from vegrip.runtime.background import run_behind

Successor = tuple[Estimator, FingerKernels]
"""An estimator, and the module of the step with it."""


class ModelSwap:
    """Builds the successors of the estimators of a node."""

    def __init__(
        self,
        factory: Callable[[Any], Callable[[str], Estimator]],
        models: Callable[[Any], Sequence[ContactModel]],
        node: str,
    ) -> None:
        self.factory = factory
        self.refused = 0
        self._models = models
        self._logger = logging.getLogger(f"vegrip.{node}")
        self._ready: dict[str, Successor] | None = None
        self._latest = 0  # number of the last request; an earlier one that ends later counts no more

    def begin(self, parameters: Any, fingers: Mapping[str, GraspFinger]) -> SideTask:
        """Start to build estimators of ``parameters`` for these fingers, with what they felt lately."""
        self._latest += 1
        pasts = {name: finger.numbers.past for name, finger in fingers.items()}
        task = SideTask(self._build, parameters, dict(fingers), pasts, self._latest)
        task.start()
        return task

    def take(self) -> dict[str, Successor] | None:
        ready, self._ready = self._ready, None
        return ready

    def _build(
        self,
        parameters: Any,
        fingers: Mapping[str, GraspFinger],
        pasts: Mapping[str, Iterable[FingertipState]],
        number: int,
    ) -> None:
        try:
            for model in self._models(parameters):
                compile_in_subprocess(model)
            make = self.factory(parameters)
            made = {name: _replayed(make(name), past) for name, past in pasts.items()}
            successors = {name: (made[name], fingers[name].numbers.module_of(made[name])) for name in made}
        except Exception as error:  # noqa: BLE001 (whatever is wrong with a model must not end the node)
            self.refused += 1
            self._logger.error("the new model is not used: %s", error)
            return
        if number == self._latest:
            self._ready = successors
            self._logger.info("the new model takes over")


def _replayed(estimator: Estimator, past: Iterable[FingertipState]) -> Estimator:
    """Let it feel what its finger felt lately.

    That began in the middle of something, with a history that is not known: how well the model explains it
    is no verdict on the model (it cost half a minute of alarm).
    """
    for state in past:
        estimator.assimilate(state)
    estimator.reset_health()
    return estimator


def compile_in_subprocess(model: ContactModel) -> None:
    """Have another process put the compiled estimator of ``model`` into the cache."""
    given = model_text(model).encode()
    done = run_behind("vegrip.grip.compile_worker", ["/dev/stdin"], idle=False, given=given)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or ["it does not compile"]
        raise ModelError(lines[-1])
