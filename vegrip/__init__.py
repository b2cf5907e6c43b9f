"""Real-time contact estimation and grip control for robot hands with soft, viscoelastic fingertips."""

from vegrip.messages import (
    ContactEstimate,
    Estimate,
    FingertipState,
    ForceCommand,
    LearnedParameter,
    ModelHealth,
    NodeStatus,
    SlipMargin,
)

__all__ = [
    "ContactEstimate",
    "Estimate",
    "FingertipState",
    "ForceCommand",
    "LearnedParameter",
    "ModelHealth",
    "NodeStatus",
    "SlipMargin",
    "__version__",
]
__version__ = "0.1.0"
