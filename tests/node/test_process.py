"""Laws of a node in a process of its own."""

import pytest

from vegrip.errors import DeviceError, VegripError
from vegrip.node import NodeBase, process
from vegrip.node.last_words import last_words
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


class Lossy(NodeBase):
    def cleanup(self):
        self.failure = "the recording x is not whole: 3 of 4 rows are lost (deleted)"

    def activate(self):
        self.finished = True


@pytest.mark.usefixtures("runtime")
def test_a_node_that_lost_what_it_was_given_ends_with_a_sentence_and_code_4(monkeypatch):
    monkeypatch.setattr(process, "find_program", lambda _: lambda *_: Lossy("lossy"))
    transport = {"kind": "can", "channel": "lossy"}
    config = NodeConfig(program="lossy", name="lossy", fingers=("thumb",), transport=transport)
    with pytest.raises(DeviceError, match="3 of 4 rows are lost"):
        process.run_node(config)
    assert last_words()["/lossy"].exit_code == 4
