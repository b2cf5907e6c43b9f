"""Two hands that know nothing of vegrip but its contract, each with a grasp force node for some seconds."""

import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
SECONDS = 3.0  # after the first command
NODE = """
fingers = ["thumb"]
[transport]
{transport}
[[node]]
program = "grasp_force"
loop.tick_period = 0.005
"""
ZEROMQ = 'kind = "zmq"\npublish = "ipc:node"\nsubscribe = ["ipc:hand"]'
CAN = """kind = "can"
interface = "socketcand"
channel = "can0"
fd = false
options = {{ host = "127.0.0.1", port = {port}, tcp_tune = true }}"""


def main() -> None:
    """Run both; fail when a hand was not commanded, or let go."""
    with tempfile.TemporaryDirectory(prefix="vg-") as folder:
        place = Path(folder)
        told = together(place, [sys.executable, str(HERE / "hand.py"), str(SECONDS)], ZEROMQ)
        print(f"Python, ZeroMQ: {told}")
        check(told)
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None:
            print("C, CAN: no C compiler here")
            return
        hand = place / "hand"
        subprocess.run(
            [compiler, "-O2", "-Wall", "-Werror", str(HERE / "hand.c"), "-o", str(hand)], check=True
        )
        port = free_port()
        told = together(place, [str(hand), str(port), str(SECONDS)], CAN.format(port=port))
        print(f"C, CAN: {told}")
        check(told)


def check(told: dict[str, float]) -> None:
    """Refuse a hand that was not commanded, or that let go."""
    if told["commands"] < 20 or not 0.5 < told["grip"] < 15.1:
        raise SystemExit(f"a hand was not commanded, or let go: {told}")


def together(folder: Path, hand: list[str], transport: str) -> dict[str, float]:
    """Run a hand and the node; return what the hand says at its end."""
    launch = folder / "node.toml"
    launch.write_text(NODE.format(transport=transport))
    env = {**os.environ, "VEGRIP_RUNTIME_DIR": f"{folder}/r"}
    command = [sys.executable, "-m", "vegrip", "node", "grasp_force", "--config", str(launch)]
    with subprocess.Popen(hand, env=env, stdout=subprocess.PIPE, text=True) as one:
        node = subprocess.Popen(
            command, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        said = one.communicate(timeout=90)[0]
        node.terminate()
        log = node.communicate(timeout=30)[1]
    if not said.strip():
        raise SystemExit(f"the hand said nothing; the node: {log}")
    told: dict[str, float] = json.loads(said)
    return told


def free_port() -> int:
    """Return a port that is free."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


if __name__ == "__main__":
    main()
