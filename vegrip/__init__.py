"""Real-time contact estimation and grip control for robot hands with soft, viscoelastic fingertips.

What stands here is public, and so are the contracts of effects, grip policies, transports and programs that
other packages add. The other modules may change without notice.

A name is imported when it is first used; ``import vegrip`` alone takes some milliseconds.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vegrip.effects import Effect
    from vegrip.estimator import ContactEstimator, EstimatorSettings, SensorNoise, Sensors
    from vegrip.grip.controller import GripController
    from vegrip.grip.safety import LimitSettings
    from vegrip.grip.settings import ControlSettings
    from vegrip.identification.changed import changed
    from vegrip.identification.compare import compare
    from vegrip.identification.diagnosis import diagnose
    from vegrip.identification.diagnosis.error_ladder import refine
    from vegrip.identification.fit import fit
    from vegrip.identification.recording import read_recording
    from vegrip.messages import (
        ContactEstimate,
        DeviceReport,
        Estimate,
        FingertipState,
        ForceCommand,
        GraspStatus,
        LearnedParameter,
        ModelHealth,
        NodeStatus,
        SlipMargin,
    )
    from vegrip.model import ContactModel, paper_model, read_model, write_model
    from vegrip.transport.open import open_endpoint

__version__ = "0.1.0"

_PLACES = {
    "ContactEstimate": "vegrip.messages",
    "ContactEstimator": "vegrip.estimator",
    "ContactModel": "vegrip.model",
    "ControlSettings": "vegrip.grip.settings",
    "DeviceReport": "vegrip.messages",
    "Effect": "vegrip.effects",
    "Estimate": "vegrip.messages",
    "EstimatorSettings": "vegrip.estimator",
    "FingertipState": "vegrip.messages",
    "ForceCommand": "vegrip.messages",
    "GraspStatus": "vegrip.messages",
    "GripController": "vegrip.grip.controller",
    "LearnedParameter": "vegrip.messages",
    "LimitSettings": "vegrip.grip.safety",
    "ModelHealth": "vegrip.messages",
    "NodeStatus": "vegrip.messages",
    "SensorNoise": "vegrip.estimator",
    "Sensors": "vegrip.estimator",
    "SlipMargin": "vegrip.messages",
    "changed": "vegrip.identification.changed",
    "compare": "vegrip.identification.compare",
    "diagnose": "vegrip.identification.diagnosis",
    "fit": "vegrip.identification.fit",
    "open_endpoint": "vegrip.transport.open",
    "paper_model": "vegrip.model",
    "read_model": "vegrip.model",
    "read_recording": "vegrip.identification.recording",
    "refine": "vegrip.identification.diagnosis.error_ladder",
    "write_model": "vegrip.model",
}
"""Public name -> module that has it."""

__all__ = [
    "ContactEstimate",
    "ContactEstimator",
    "ContactModel",
    "ControlSettings",
    "DeviceReport",
    "Effect",
    "Estimate",
    "EstimatorSettings",
    "FingertipState",
    "ForceCommand",
    "GraspStatus",
    "GripController",
    "LearnedParameter",
    "LimitSettings",
    "ModelHealth",
    "NodeStatus",
    "SensorNoise",
    "Sensors",
    "SlipMargin",
    "__version__",
    "changed",
    "compare",
    "diagnose",
    "fit",
    "open_endpoint",
    "paper_model",
    "read_model",
    "read_recording",
    "refine",
    "write_model",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is asked for (PEP 562)."""
    if name not in _PLACES:
        raise AttributeError(f"module 'vegrip' has no attribute {name!r}")
    found = getattr(importlib.import_module(_PLACES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})
