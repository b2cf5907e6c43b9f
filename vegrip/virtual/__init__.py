"""A virtual hand: an independent truth for soft fingertips that hold an object.

It shares no physics with the rest of vegrip: the hereditary integral is summed over the stored history and
friction over the elements of the patch, so that an estimator that agrees with it agrees with something else
than itself.
"""

from vegrip.virtual.disturbance import Disturbance, disturbances
from vegrip.virtual.hand import FingerTruth, VirtualHand
from vegrip.virtual.settings import FingertipSettings, HandSettings, random_fingertip

__all__ = [
    "Disturbance",
    "FingerTruth",
    "FingertipSettings",
    "HandSettings",
    "VirtualHand",
    "disturbances",
    "random_fingertip",
]
