"""The estimator of a model, or all of a finger, as C99 for firmware, with a self-test."""

from vegrip.export.export import Exported, write_export
from vegrip.export.precision import Request

__all__ = ["Exported", "Request", "write_export"]
