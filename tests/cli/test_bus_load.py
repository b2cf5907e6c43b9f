"""``vegrip bus-load``: one JSON object, a verdict in a sentence, and refusals that name the bound."""

import json

from vegrip.cli import main


def run(capsys, *arguments):
    code = main(["bus-load", *arguments])
    return code, capsys.readouterr()


def test_json_has_load_frames_and_verdict(capsys):
    code, out = run(capsys, "--fingers", "2", "--rate", "200", "--queue", "priority", "--json")
    told = json.loads(out.out)
    assert code == 0
    assert told["fits"]
    assert 0.0 < told["load"] < told["worst_load"] < 1.0
    states = [frame for frame in told["frames"] if frame["name"] == "FingertipStateFd"]
    assert [frame["identifier"] for frame in states] == [0x200, 0x201]
    assert all(frame["longest_us"] <= frame["wait_us"] <= frame["response_us"] for frame in told["frames"])


def test_an_overloaded_bus_is_told_with_the_remedy(capsys):
    code, out = run(capsys, "--layout", "classic", "--rate", "1000")
    assert code == 0
    assert "does not fit" in out.out
    assert "use FD" in out.out


def test_what_the_identifiers_do_not_hold_is_refused(capsys):
    code, out = run(capsys, "--fingers", "9")
    assert code == 3
    assert "1 .. 8" in out.err
    assert run(capsys, "--layout", "fdx")[0] == 2


def test_no_number_is_cut_off_where_there_is_no_terminal(capsys):
    _, out = run(capsys, "--fingers", "8", "--rate", "200", "--queue", "priority")
    assert "…" not in out.out
    assert "FingertipStateFd" in out.out
