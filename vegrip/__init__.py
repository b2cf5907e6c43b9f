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
    from vegrip.grip.force_parts import ForceParts
    from vegrip.grip.friction_settings import FrictionSettings
    from vegrip.grip.known_objects import ObjectFriction
    from vegrip.grip.policies.margin_grip import GripSettings
    from vegrip.grip.safety import FailSafeSettings, LimitSettings, WatchdogSettings
    from vegrip.grip.settings import ControlSettings
    from vegrip.identification.changed import changed
    from vegrip.identification.compare import Comparison, compare
    from vegrip.identification.diagnosis import Diagnosis, diagnose
    from vegrip.identification.diagnosis.error_ladder import Ladder, Refinement, ladder, refine
    from vegrip.identification.draft import Draft, draft
    from vegrip.identification.fit import Fit, Noise, fit, noise_of
    from vegrip.identification.recording import Fingertip, Recording, read_recording, write_recording
    from vegrip.identification.recording.import_file import import_recording
    from vegrip.identification.samples import sample
    from vegrip.messages import (
        Condition,
        ContactEstimate,
        DeviceReport,
        Estimate,
        FingertipState,
        ForceCommand,
        GraspStatus,
        LearnedParameter,
        ModelHealth,
        NodeStatus,
        Reason,
        SlipMargin,
    )
    from vegrip.model import ContactModel, paper_model, read_model, write_model
    from vegrip.transport.open import open_endpoint

__version__ = "0.2.0"

_PLACES = {
    "Comparison": "vegrip.identification.compare",
    "Condition": "vegrip.messages",
    "ContactEstimate": "vegrip.messages",
    "ContactEstimator": "vegrip.estimator",
    "ContactModel": "vegrip.model",
    "ControlSettings": "vegrip.grip.settings",
    "DeviceReport": "vegrip.messages",
    "Diagnosis": "vegrip.identification.diagnosis",
    "Draft": "vegrip.identification.draft",
    "Effect": "vegrip.effects",
    "Estimate": "vegrip.messages",
    "EstimatorSettings": "vegrip.estimator",
    "FailSafeSettings": "vegrip.grip.safety",
    "Fingertip": "vegrip.identification.recording",
    "FingertipState": "vegrip.messages",
    "Fit": "vegrip.identification.fit",
    "ForceCommand": "vegrip.messages",
    "ForceParts": "vegrip.grip.force_parts",
    "FrictionSettings": "vegrip.grip.friction_settings",
    "GraspStatus": "vegrip.messages",
    "GripController": "vegrip.grip.controller",
    "GripSettings": "vegrip.grip.policies.margin_grip",
    "Ladder": "vegrip.identification.diagnosis.error_ladder",
    "LearnedParameter": "vegrip.messages",
    "LimitSettings": "vegrip.grip.safety",
    "ModelHealth": "vegrip.messages",
    "NodeStatus": "vegrip.messages",
    "Noise": "vegrip.identification.fit",
    "ObjectFriction": "vegrip.grip.known_objects",
    "Reason": "vegrip.messages",
    "Recording": "vegrip.identification.recording",
    "Refinement": "vegrip.identification.diagnosis.error_ladder",
    "SensorNoise": "vegrip.estimator",
    "Sensors": "vegrip.estimator",
    "SlipMargin": "vegrip.messages",
    "WatchdogSettings": "vegrip.grip.safety",
    "changed": "vegrip.identification.changed",
    "compare": "vegrip.identification.compare",
    "diagnose": "vegrip.identification.diagnosis",
    "draft": "vegrip.identification.draft",
    "fit": "vegrip.identification.fit",
    "import_recording": "vegrip.identification.recording.import_file",
    "ladder": "vegrip.identification.diagnosis.error_ladder",
    "noise_of": "vegrip.identification.fit",
    "open_endpoint": "vegrip.transport.open",
    "paper_model": "vegrip.model",
    "read_model": "vegrip.model",
    "read_recording": "vegrip.identification.recording",
    "refine": "vegrip.identification.diagnosis.error_ladder",
    "sample": "vegrip.identification.samples",
    "write_model": "vegrip.model",
    "write_recording": "vegrip.identification.recording",
}
"""Public name -> module that has it."""

__all__ = [
    "Comparison",
    "Condition",
    "ContactEstimate",
    "ContactEstimator",
    "ContactModel",
    "ControlSettings",
    "DeviceReport",
    "Diagnosis",
    "Draft",
    "Effect",
    "Estimate",
    "EstimatorSettings",
    "FailSafeSettings",
    "Fingertip",
    "FingertipState",
    "Fit",
    "ForceCommand",
    "ForceParts",
    "FrictionSettings",
    "GraspStatus",
    "GripController",
    "GripSettings",
    "Ladder",
    "LearnedParameter",
    "LimitSettings",
    "ModelHealth",
    "NodeStatus",
    "Noise",
    "ObjectFriction",
    "Reason",
    "Recording",
    "Refinement",
    "SensorNoise",
    "Sensors",
    "SlipMargin",
    "WatchdogSettings",
    "__version__",
    "changed",
    "compare",
    "diagnose",
    "draft",
    "fit",
    "import_recording",
    "ladder",
    "noise_of",
    "open_endpoint",
    "paper_model",
    "read_model",
    "read_recording",
    "refine",
    "sample",
    "write_model",
    "write_recording",
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
