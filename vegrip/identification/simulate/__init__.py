"""A model file put through a protocol: a recording as the model would give it, with the noise of sensors."""

from vegrip.identification.simulate.protocol import Protocol, Segment, read_protocol, write_protocol
from vegrip.identification.simulate.run import SENSORS, like, simulate

__all__ = ["SENSORS", "Protocol", "Segment", "like", "read_protocol", "simulate", "write_protocol"]
