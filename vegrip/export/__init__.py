"""The estimator of a model as C99 for firmware, with a self-test that shows that the numbers are the same."""

from vegrip.export.export import Exported, export_estimator
from vegrip.export.request import Request

__all__ = ["Exported", "Request", "export_estimator"]
