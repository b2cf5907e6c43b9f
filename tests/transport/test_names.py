"""Laws of addresses and of the folder they live in."""

import os
from pathlib import Path

import pytest

from vegrip.errors import ConfigError, DeviceError
from vegrip.host.folders import runtime_folder, socket_path
from vegrip.transport.curve import check_reach, is_local, resolve


@pytest.mark.parametrize(
    "address",
    ["tcp://127.0.0.1:5600", "tcp://127.8.8.8:1", "tcp://[::1]:5600", "tcp://localhost:1"],
)
def test_addresses_of_this_machine_need_no_keys(address):
    assert is_local(address)
    check_reach(address, encrypted=False)


@pytest.mark.parametrize(
    "address",
    [
        "tcp://*:5600",
        "tcp://0.0.0.0:5600",
        "tcp://192.168.1.5:1",
        "tcp://eth0:1",
        "tcp://[::]:1",
        "tcp://robot:1",
    ],
)
def test_addresses_beyond_this_machine_are_refused_without_keys(address):
    with pytest.raises(ConfigError, match="curve"):
        check_reach(address, encrypted=False)
    check_reach(address, encrypted=True)


@pytest.mark.parametrize(
    "address",
    [
        "udp://1.2.3.4:5",
        "hand",
        "tcp:5600",
        "tcp://",
        "",
        "ipc:",
        "ipc://",
        "ipc:../x",
        "ipc:a/b",
        "ipc:/tmp/x",
        "ipc:..",
        "ipc:.hidden",
        "ipc:@x",
        "ipc:*",
        "ipc:a b",
        "ipc:a~",
        "ipc:a\0b",
        "ipc:a\n",
        "ipc://x",
        "ipc://./x",
        "ipc://*",
        "ipc:///a/../tmp/x",
        "ipc:///tmp/\0x",
        "inproc://x",
    ],
)
def test_what_is_no_address_is_refused_with_the_right_form(address):
    with pytest.raises(ConfigError, match="ipc:NAME"):
        resolve(address)


@pytest.fixture
def private(runtime):
    folder = Path(runtime) / "mine"
    folder.mkdir(mode=0o700)
    return folder


def test_a_path_in_a_folder_of_this_user_alone_needs_no_keys(private):
    check_reach(resolve(f"ipc://{private}/x"), encrypted=False)


@pytest.mark.parametrize("name", ["@vegrip", "@/x", "/tmp/x", "/x", "/absent/folder/x"])  # noqa: S108
def test_a_socket_that_others_can_reach_or_replace_is_refused_without_keys(name):
    address = resolve(f"ipc://{name}")
    with pytest.raises(ConfigError, match="curve"):
        check_reach(address, encrypted=False)
    check_reach(address, encrypted=True)


@pytest.mark.parametrize("mode", [0o701, 0o710, 0o702, 0o770, 0o777, 0o1777])
@pytest.mark.parametrize("level", ["the folder", "the one above"])
def test_a_folder_that_others_can_enter_or_exchange_is_refused_without_keys(private, mode, level):
    inner = private / "inner"
    inner.mkdir(mode=0o700)
    (inner if level == "the folder" else private).chmod(mode)
    harmless = level == "the one above" and (not mode & 0o022 or mode & 0o1000)
    address = resolve(f"ipc://{inner}/x")
    if harmless:
        check_reach(address, encrypted=False)
    else:
        with pytest.raises(ConfigError, match="curve"):
            check_reach(address, encrypted=False)


def test_a_link_on_the_way_counts_with_the_folder_it_leads_to(private):
    other = private / "open"
    other.mkdir()
    other.chmod(0o777)
    (private / "link").symlink_to(other)
    with pytest.raises(ConfigError, match="curve"):
        check_reach(resolve(f"ipc://{private}/link/x"), encrypted=False)


def test_a_short_name_is_a_socket_in_the_private_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", str(tmp_path / "run"))
    assert resolve("ipc:hand") == f"ipc://{tmp_path}/run/zmq/hand"


def test_a_path_too_long_for_a_socket_is_refused():
    with pytest.raises(ConfigError, match="too long"):
        resolve("ipc:///" + "x" * 200)
    with pytest.raises(DeviceError, match="too long"):
        socket_path("can", "x" * 200)


def test_the_folder_of_sockets_is_private(monkeypatch, tmp_path):
    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", str(tmp_path / "run"))
    assert runtime_folder("can").stat().st_mode & 0o777 == 0o700
    (tmp_path / "run").chmod(0o755)
    with pytest.raises(DeviceError, match="other users"):
        runtime_folder("can")


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give files away")
def test_a_link_that_another_user_has_made_is_no_private_folder(monkeypatch, tmp_path):
    (tmp_path / "home").mkdir(mode=0o700)
    (tmp_path / "run").symlink_to(tmp_path / "home")
    os.chown(tmp_path / "run", 12345, 12345, follow_symlinks=False)
    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", str(tmp_path / "run"))
    with pytest.raises(DeviceError, match="symbolic link that another user has made"):
        runtime_folder("can")
    assert list((tmp_path / "home").iterdir()) == []


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give files away")
def test_a_folder_of_another_user_is_refused_before_anything_is_made_in_it(monkeypatch, tmp_path):
    (tmp_path / "run").mkdir(mode=0o700)
    os.chown(tmp_path / "run", 12345, 12345)
    monkeypatch.setenv("VEGRIP_RUNTIME_DIR", str(tmp_path / "run"))
    with pytest.raises(DeviceError, match="belongs to another user"):
        runtime_folder("can")
    assert list((tmp_path / "run").iterdir()) == []
