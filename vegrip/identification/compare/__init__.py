"""Where a model fails: residuals by regime, models and recordings side by side."""

from vegrip.identification.compare.comparison import Comparison, compare
from vegrip.identification.compare.where import Regime

__all__ = ["Comparison", "Regime", "compare"]
