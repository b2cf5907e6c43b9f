"""Where a model fails: residuals by regime, models and recordings side by side."""

from vegrip.compare.comparison import Comparison, compare
from vegrip.compare.where import Regime

__all__ = ["Comparison", "Regime", "compare"]
