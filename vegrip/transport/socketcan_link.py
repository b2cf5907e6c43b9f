"""Whether a SocketCAN interface can carry what is asked of it: asked of the kernel before the bus is opened.

The kernel lets a socket be bound to an interface that is down or too small for CAN FD, and complains only
when the first frame is read or sent; a node should say so when it starts. One that is missing is found here
too, because python-can leaves a socket open when it finds none.
"""

import errno
import fcntl
import os
import socket
import struct

import can

GET_FLAGS, GET_MTU = 0x8913, 0x8921  # SIOCGIFFLAGS, SIOCGIFMTU of linux/sockios.h
UP = 1  # IFF_UP
FD_MTU = 72  # [bytes] of struct canfd_frame; an interface for classic frames has 16


def check_link(channel: str, *, fd: bool) -> None:
    """Refuse an interface that is missing, down, or carries classic frames only though ``fd`` is asked.

    Raises:
        OSError: EAFNOSUPPORT, ENODEV or ENETDOWN, as the kernel says or would say later.
        can.CanInitializationError: no room for CAN FD frames.

    """
    if not _ask(channel, GET_FLAGS, "h") & UP:
        raise OSError(errno.ENETDOWN, os.strerror(errno.ENETDOWN))
    if fd and _ask(channel, GET_MTU, "i") < FD_MTU:
        raise can.CanInitializationError(
            "it carries classic frames only; set fd = false, or make it CAN FD: "
            f"`sudo ip link set {channel} type can ... dbitrate 5000000 fd on` "
            f"(a virtual one: `sudo ip link set {channel} mtu {FD_MTU}`)"
        )


def _ask(channel: str, what: int, kind: str) -> int:
    request = struct.pack("=16s16x", channel.encode()[:15])  # struct ifreq begins with the name
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as unbound:
        answer = fcntl.ioctl(unbound, what, request)
    return int(struct.unpack_from(f"={kind}", answer, 16)[0])
