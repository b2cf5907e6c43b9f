"""What the kernels find in a generated module besides ``advance`` and ``readout``: sizes, places, gauge.

A list of names for readers and linters; the values belong to one model and are written by
:meth:`vegrip.estimator.layout.Layout.constants`.
"""

from vegrip.contact.limit_surface.fast import gauge, radius_gradient
from vegrip.model.generated import Floats, advance, readout
