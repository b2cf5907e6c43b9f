"""What killed processes leave behind is removed by those who come after, and nothing of the living is."""

import socket
import time

import pytest

from vegrip.host import folders
from vegrip.host.folders import ASIDE, MIN_SOCKET_AGE_S, locked, remove_leftovers, runtime_folder

pytestmark = pytest.mark.usefixtures("runtime")


def later():
    return time.time() + 2 * MIN_SOCKET_AGE_S


def dead(path, kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_UNIX, kind) as server:
        server.bind(str(path))
        server.listen()


@pytest.mark.parametrize(
    ("part", "name", "kind"),
    [
        ("zmq", "hand", socket.SOCK_STREAM),
        ("nodes", "0123456789ab.c", socket.SOCK_STREAM),
        ("nodes", "0123456789ab.t", socket.SOCK_STREAM),
        ("nodes", "0123456789ab.c~", socket.SOCK_STREAM),
        ("can", "demo.bus", socket.SOCK_SEQPACKET),
    ],
)
def test_a_socket_that_nobody_serves_is_removed_one_that_is_served_or_new_is_not(
    part, name, kind, monkeypatch
):
    path = runtime_folder(part) / name
    dead(path, kind)
    remove_leftovers()
    assert path.exists(), "it may be about to listen"
    remove_leftovers(later())
    assert not path.exists()
    with socket.socket(socket.AF_UNIX, kind) as server:
        server.bind(str(path))
        server.listen()
        remove_leftovers(later())
        assert path.exists()
        monkeypatch.setattr(folders, "_served", set)  # as one sees those of another namespace
        remove_leftovers(later())
        assert path.exists()


def test_a_lock_that_nobody_holds_is_removed_one_that_is_held_is_not():
    held, left = runtime_folder("can") / "held.lock", runtime_folder("can") / "left.lock"
    handle = locked(held)
    assert handle is not None
    left.write_text("1\n")
    remove_leftovers()
    assert held.exists()
    assert not left.exists()
    assert locked(held) is None


def test_what_is_no_socket_stays():
    path = runtime_folder("zmq") / "notes"
    path.write_text("")
    remove_leftovers(later())
    assert path.exists()


def test_a_socket_that_lets_nobody_in_for_the_moment_is_not_even_tried():
    path = runtime_folder("zmq") / "full"
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(path))
        server.listen()
        server.setblocking(False)
        path.rename(path.with_name(f"full{ASIDE}"))
        remove_leftovers(later())
        assert path.with_name(f"full{ASIDE}").exists()
        with pytest.raises(BlockingIOError):
            server.accept()
