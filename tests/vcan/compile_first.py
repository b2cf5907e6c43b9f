"""Compile what the programs of these tests run: inside the emulated kernel it would take minutes.

What is compiled in there is thrown away as well, and every start of a node would compile it again.
"""

from vegrip.nodes.grasp_force import build

from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.model import paper_model
from vegrip.runtime import NodeContext
from vegrip.transport.codec import CanCodec
from vegrip.virtual import HandSettings, VirtualHand

FINGERS = ("thumb", "index")

VirtualHand(HandSettings(), 0, ()).step(0.02, {})
ContactEstimator(paper_model(9e-3), SensorNoise())
for fd in (True, False):
    codec = CanCodec(FINGERS, fd=fd)
    node = build({}, NodeContext("grasp_force", fingers=FINGERS))
    node.configure()
    node.run_compiled({finger: codec.line(finger) for finger in FINGERS})
