"""Messages <-> bytes: CAN (classic and FD) and msgpack, generated from the files of ``proto/``.

Pure: no socket, no clock. What comes from the wire is never trusted and never raises; it decodes to a
message or to None, and every refusal is counted under its name.
"""

from vegrip.transport.codec.can_codec import CanCodec
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.msgpack_codec import MsgpackCodec

__all__ = ["CanCodec", "Frame", "MsgpackCodec"]
