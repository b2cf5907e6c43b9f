"""Launch files: what they may say, and what those that come with vegrip say."""

from pathlib import Path

import pytest
import vegrip.launch

from vegrip.errors import ConfigError
from vegrip.messages import USUAL_FINGERS
from vegrip.runtime.launch_file import find_launch_file, read_launch_file
from vegrip.runtime.node import NodeContext, find_program

SHIPPED = sorted(Path(vegrip.launch.__file__).parent.glob("*.toml"))


def written(folder, text):
    path = folder / "x.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_node_of_a_shipped_file_can_be_built(path):
    nodes = read_launch_file(find_launch_file(path.stem))
    assert nodes
    for node in nodes:
        context = NodeContext(node.name or node.program, node.namespace, node.fingers)
        assert find_program(node.program)(node.parameters, context).name == context.name


def test_what_is_said_above_holds_for_every_node_unless_it_says_otherwise(tmp_path):
    path = written(
        tmp_path,
        """
        fingers = ["thumb", "index"]
        namespace = "left"
        transport = { kind = "can", channel = "a" }
        [[node]]
        program = "echo"
        [[node]]
        program = "echo"
        name = "other"
        namespace = "right"
        transport = { kind = "zmq", publish = "ipc:x" }
        loop.tick_period = 0.01
        """,
    )
    first, second = read_launch_file(path)
    assert (first.full_name, first.transport["channel"]) == ("/left/echo", "a")
    assert (second.full_name, second.transport) == ("/right/other", {"kind": "zmq", "publish": "ipc:x"})
    assert first.fingers == second.fingers == ("thumb", "index")
    assert (first.loop.tick_period, second.loop.tick_period) == (0.002, 0.01)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "node"),
        ("[[node]]", "program"),
        ("[transport]\ndatabitrate = 2\n[[node]]\nprogram = 'echo'", "did you mean data_bitrate?"),
        ("[[node]]\nprogram = 'echo'\ntransport = { kind = 'canopen', node = 3 }", "unknown key 'node'"),
        ("[transport]\nkind = 'zmq'\nsubscibe = ['ipc:a']\n[[node]]\nprogram = 'echo'", "subscribe"),
        ("[transport]\nkind = 'zmq'\ncurve.owm = 'a'\n[[node]]\nprogram = 'echo'", "unknown key 'owm'"),
        ("[transport]\nbitrate = 5\n[[node]]\nprogram = 'echo'", "must lie in"),
        ("fingers = { thumb = {} }\ntransport = { kind = 'can', chanel = 'a' }", "did you mean channel?"),
        ("[[node]]\nprogram = 'echo'\nresart = 'always'", "restart"),
        ("[[node]]\nprogram = 'echo'\nrestart = 'often'", "never, on-failure, always"),
        (
            "[[node]]\nprogram = 'echo'\ntransport.kind = inf",
            "'kind' of the transport is inf; it must be one of can",
        ),
        ("[[node]]\nprogram = 'echo'\ntransport.kind = 'telex'", "it must be one of can"),
        ("fingers = ['thumb', 2]\n[[node]]\nprogram = 'echo'", "number 2, is 2; it must be text"),
        ("[[node]]\nprogram = 'echo'\nremap = { '/a' = 1 }", "it must be text"),
        ("node = [1]", "it must be a table"),
        ("x = " + "[" * 3000 + "]" * 3000, "not valid TOML"),
        ("x = " + "9" * 6000, "not valid TOML"),
        ("[[node]]\nprogram = 'echo'\n[[node]]\nprogram = 'echo'", "two nodes"),
        ("[[node]]\nprogram = 'echo'\nloop.tick_period = 0", "0.0001 .. 10 s"),
        ("[[node]]\nprogram = 'echo'\nname = 'a b'", "letters"),
        ("speed = 3\n[[node]]\nprogram = 'echo'", "speed"),
        ("[[node]\n", "TOML"),
    ],
)
def test_a_mistake_is_one_sentence_that_names_the_file(tmp_path, text, words):
    with pytest.raises(ConfigError, match=words) as caught:
        read_launch_file(written(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_an_unknown_file_names_those_there_are():
    with pytest.raises(ConfigError, match="can0, canopen, demo, vcan, zmq"):
        find_launch_file("nothing")


def test_the_default_is_a_hand_of_five_fingers(tmp_path):
    (node,) = read_launch_file(written(tmp_path, "[[node]]\nprogram = 'echo'"))
    assert node.fingers == USUAL_FINGERS


def test_realtime_is_on_unless_the_file_or_the_node_switches_it_off(tmp_path):
    assert all(node.realtime for node in read_launch_file(find_launch_file("demo")))
    file = tmp_path / "launch.toml"
    file.write_text(
        'realtime = false\n[[node]]\nprogram = "echo"\n[[node]]\nprogram = "record"\nrealtime = true\n'
    )
    assert [node.realtime for node in read_launch_file(file)] == [False, True]
