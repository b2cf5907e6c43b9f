"""Laws of a node in a process of its own."""

import pytest

from vegrip.errors import DeviceError, VegripError
from vegrip.node import NodeBase, process
from vegrip.node.launch_file import NodeConfig


class Broken(NodeBase):
    def configure(self):
        raise ZeroDivisionError("somebody's own effect\nin many lines")


@pytest.mark.usefixtures("runtime")
def test_whatever_a_node_raises_at_its_start_is_one_sentence(monkeypatch):
    monkeypatch.setattr(process, "find_program", lambda _: lambda *_: Broken("broken"))
    transport = {"kind": "can", "channel": "broken"}
    config = NodeConfig(program="broken", name="broken", fingers=("thumb",), transport=transport)
    with pytest.raises(
        VegripError, match=r"broken cannot be started: ZeroDivisionError: somebody's own effect$"
    ):
        process.run_node(config)


@pytest.mark.usefixtures("runtime")
def test_a_node_that_may_open_too_few_files_does_not_start(monkeypatch):
    monkeypatch.setattr(process.descriptors, "limit", lambda: 300)
    monkeypatch.setattr(process.descriptors.resource, "setrlimit", lambda *_: None)
    config = NodeConfig(program="echo", name="echo", fingers=("thumb",), transport={"kind": "can"})
    with pytest.raises(DeviceError, match="only 300 files may be open"):
        process.run_node(config)
