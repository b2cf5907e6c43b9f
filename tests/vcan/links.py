"""Network links by rtnetlink: make, remove, raise and lower vcan interfaces without iproute2.

As a program it makes interfaces and becomes a command that uses them: ``links.py vcan0 vcan1 -- COMMAND...``.
"""

import os
import socket
import struct
import sys
from collections.abc import Mapping

ROUTE = 0  # NETLINK_ROUTE
NEW_LINK, DELETE_LINK, ERROR = 16, 17, 2  # RTM_NEWLINK, RTM_DELLINK, NLMSG_ERROR
REQUEST, ACKNOWLEDGE, CREATE, EXCLUSIVE = 0x1, 0x4, 0x400, 0x200  # NLM_F_*
NAME, MTU, LINK_INFO, KIND = 3, 4, 18, 1  # IFLA_IFNAME, IFLA_MTU, IFLA_LINKINFO, IFLA_INFO_KIND
UP = 1  # IFF_UP
CLASSIC_MTU, FD_MTU = 16, 72  # [bytes] of struct can_frame and struct canfd_frame


def add(name: str, mtu: int = FD_MTU) -> None:
    """Make the vcan interface ``name`` and raise it."""
    kind = {NAME: _text(name), MTU: struct.pack("=I", mtu), LINK_INFO: _attributes({KIND: _text("vcan")})}
    _request(NEW_LINK, CREATE | EXCLUSIVE, "", up=False, attributes=kind)
    set_up(name)


def remove(name: str) -> None:
    """Remove the interface ``name``."""
    _request(DELETE_LINK, 0, name, up=False)


def set_up(name: str) -> None:
    """Raise the interface ``name``."""
    _request(NEW_LINK, 0, name, up=True)


def set_down(name: str) -> None:
    """Lower the interface ``name``."""
    _request(NEW_LINK, 0, name, up=False)


def _request(
    kind: int, flags: int, name: str, *, up: bool, attributes: Mapping[int, bytes] | None = None
) -> None:
    index = socket.if_nametoindex(name) if name else 0
    link = struct.pack("=BxHiII", socket.AF_UNSPEC, 0, index, UP if up else 0, UP)  # struct ifinfomsg
    body = link + _attributes(attributes or {})
    header = struct.pack("=IHHII", 16 + len(body), kind, REQUEST | ACKNOWLEDGE | flags, 1, 0)
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, ROUTE) as netlink:
        netlink.sendall(header + body)
        answer = netlink.recv(65_536)
    _, answered, _, _, _, error = struct.unpack_from("=IHHIIi", answer)
    if answered != ERROR or error:
        raise OSError(-error, f"{name or 'vcan'}: {os.strerror(-error)}")


def _attributes(values: Mapping[int, bytes]) -> bytes:
    packed = b""
    for number, value in values.items():
        packed += struct.pack("=HH", 4 + len(value), number) + value + bytes(-len(value) % 4)
    return packed


def _text(value: str) -> bytes:
    return value.encode() + b"\0"


def main() -> None:
    """Make the interfaces named first, then become the command."""
    names, command = (part.split("\n") for part in "\n".join(sys.argv[1:]).split("\n--\n", 1))
    set_up("lo")
    for name in names:
        add(name)
    os.execvp(command[0], command)  # noqa: S606 (becomes what the caller gave)


if __name__ == "__main__":
    main()
