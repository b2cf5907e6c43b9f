"""A hand in Python without vegrip, from proto/README.md alone: the thumb on ZeroMQ, 200 states a second.

python hand.py 5: seconds after the first command. The node: publish = "ipc:node", subscribe = ["ipc:hand"].
"""

import json
import os
import random
import sys
import time
import zlib
from pathlib import Path

import msgpack
import zmq

FOLDER = os.environ.get("VEGRIP_RUNTIME_DIR") or (
    f"{os.environ['XDG_RUNTIME_DIR']}/vegrip"
    if "XDG_RUNTIME_DIR" in os.environ
    else f"/tmp/vegrip-{os.getuid()}"  # noqa: S108
)
PATIENCE = 60.0  # [s] for the first command
STATE, COMMAND = b"/hand/thumb/state", b"/hand/thumb/force_command"


def crc32p4(data: bytes) -> int:
    """E2E profile 4: polynomial 0xF4ACFB13, reflected, start and final XOR 0xFFFFFFFF."""
    value = 0xFFFFFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xC8DF352F if value & 1 else 0)  # the polynomial, its bits reversed
    return value ^ 0xFFFFFFFF


def packed(topic: bytes, body: dict) -> bytes:
    """Twelve bytes of header (length, counter, Data ID, CRC), then the map."""
    data = msgpack.packb(body)
    head = (12 + len(data)).to_bytes(2, "big") + (body["seq"] & 0xFFFF).to_bytes(2, "big")
    head += zlib.crc32(topic).to_bytes(4, "big")
    return head + crc32p4(head + data).to_bytes(4, "big") + data


def unpacked(topic: bytes, payload: bytes) -> dict | None:
    """Return the map, None for what is damaged, of another topic or another version."""
    head, crc, data = payload[:8], payload[8:12], payload[12:]
    if head[4:] != zlib.crc32(topic).to_bytes(4, "big") or crc != crc32p4(head + data).to_bytes(4, "big"):
        return None
    body = msgpack.unpackb(data)
    return body if body.get("version") == 1 else None


def main() -> None:
    """Send states, obey commands while they are in force, else hold."""
    for folder in (Path(FOLDER), Path(FOLDER, "zmq")):
        folder.mkdir(mode=0o700, exist_ok=True)
    context = zmq.Context()
    out, inward = context.socket(zmq.PUB), context.socket(zmq.SUB)
    out.bind(f"ipc://{FOLDER}/zmq/hand")
    inward.connect(f"ipc://{FOLDER}/zmq/node")
    inward.subscribe(COMMAND)
    grip, wanted, until, commands, noise = 1.5, 1.5, 0, 0, random.Random(1)  # noqa: S311
    end = time.monotonic() + PATIENCE
    seq = 0
    while time.monotonic() < end:
        while inward.poll(0):
            command = unpacked(COMMAND, inward.recv_multipart()[1])
            if command is not None and 0.0 <= command["normal_force"] < 1e3:
                wanted, until, commands = command["normal_force"], command["expires"], commands + 1
                end = time.monotonic() + float(sys.argv[1]) if commands == 1 else end
        now = time.monotonic_ns()
        grip += 0.2 * ((wanted if now < until else grip) - grip)  # no command in force: hold as it is
        body = {
            "version": 1,
            "stamp": now,
            "finger": "thumb",
            "seq": seq,
            "normal_force": grip + noise.gauss(0, 0.01),
        }
        body |= {"tangential_force_x": 0.5 + noise.gauss(0, 0.01), "tangential_force_y": noise.gauss(0, 0.01)}
        out.send_multipart([STATE, packed(STATE, body)])
        seq += 1
        time.sleep(0.005)
    print(json.dumps({"commands": commands, "grip": round(grip, 3)}))
    context.destroy(linger=0)


if __name__ == "__main__":
    main()
