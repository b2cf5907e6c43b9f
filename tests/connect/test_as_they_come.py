"""Databases and frames as they come: values that are none, short frames, faulty messages, encodings."""

import json
from pathlib import Path

import pytest

from vegrip.cli import main
from vegrip.config import parse_toml
from vegrip.connect.drafts import BY_USER, Draft, FingerDraft
from vegrip.connect.guess import finger_of, words_of
from vegrip.connect.proposal import Proposal
from vegrip.connect.questions import learn
from vegrip.errors import ConfigError
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.database import Database, read_dbc
from vegrip.transport.maps.signals import says_nothing

NAN = float("nan")
SAME = ("signal", "sign", "unit")
HEAD = 'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: HAND HOST\n\n'
TIP = """BO_ 257 Finger1_State: 8 HAND
 SG_ Fz : 0|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Fx : 16|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Fy : 32|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Depth : 48|16@1- (1,0) [-30000|30000] "um" HOST
"""
NAMED = '\nVAL_ 257 Fz 32767 "SNA" 32766 "Error" ;\nVAL_ 257 Depth 32767 "Signal_not_available" ;\n'
MAP = """database = "hand.dbc"
[fingers.thumb.normal_force]
signal = "Finger1_State.Fz"
{more}
[fingers.thumb.displacement]
signal = "Finger1_State.Depth"
zero_is_measured = true
"""


def data(fz=0, fx=0, fy=20, depth=0) -> bytes:
    return b"".join(v.to_bytes(2, "little", signed=True) for v in (fz, fx, fy, depth))


def press() -> list[bytes]:
    found = []
    for k in range(1000):
        s = min(max((k - 200) / 300, 0.0), 1.0) if k < 800 else 0.0
        shear = 500 * max(0.0, 1.0 - abs(k - 650) / 150)
        found.append(data(round(2000 * s**1.5) + k % 3, round(shear), 20 + k % 2, round(1000 * s)))
    return found


def log(path: Path, frames: list[bytes], identifier=257) -> Path:
    head = [f"({1.7e9 + 0.01 * k:.6f}) can0 {identifier:03X}#" for k in range(len(frames))]
    lines = (f"{one}{d.hex().upper()}\n" for one, d in zip(head, frames, strict=True))
    path.write_text("".join(lines))
    return path


def connect(folder: Path, database: str, frames: list[bytes], capsys, *more: str):
    (folder / "hand.dbc").write_text(database)
    command = ["connect", str(folder / "hand.dbc"), "--log", str(log(folder / "a.log", frames))]
    command += [
        "-o",
        str(folder / "hand.toml"),
        "--force",
        "--rest",
        "0..2",
        "--press",
        "2..5",
        "--json",
        *more,
    ]
    code = main(command)
    captured = capsys.readouterr()
    return code, (json.loads(captured.out) if captured.out.startswith("{") else None), captured.err


def codec(folder: Path, database: str = HEAD + TIP, more: str = "") -> MappedCodec:
    (folder / "hand.dbc").write_text(database)
    (folder / "hand.toml").write_text(MAP.format(more=more))
    return MappedCodec(open_plan(folder / "hand.toml"))


def test_what_a_database_names_not_available_is_missing_and_a_declared_range_is_kept(tmp_path):
    hand = codec(tmp_path, HEAD + TIP + NAMED)
    for raw, force in (
        (32767, None),
        (32766, None),
        (30001, None),
        (-30001, None),
        (30000, 30.0),
        (1, 0.001),
    ):
        (state,) = hand.decode_all(Frame(257, data(raw), False, 1))
        assert state.normal_force == (
            force if force is not None else pytest.approx(float("nan"), nan_ok=True)
        )
    (state,) = codec(tmp_path, HEAD + TIP + NAMED, "all_is_measured = true").decode_all(
        Frame(257, data(32767), False, 1)
    )
    assert state.normal_force == 32.767


@pytest.mark.parametrize(
    "name", ["SNA", "Error", "Signal_not_available", "NotValid", "Init", "ungültig", "N/A"]
)
def test_names_that_say_nothing_is_measured(name):
    assert says_nothing(name)


@pytest.mark.parametrize("name", ["Off", "slip", "Contact", "Terrain", "High", "Mirrored", "standard"])
def test_names_of_values(name):
    assert not says_nothing(name)


@pytest.mark.parametrize(
    "bad",
    [
        lambda k, d: data(32766) if 300 < k < 306 else d,
        lambda k, d: data(32767, depth=32767) if k < 9 else d,
        lambda k, d: data(-32768) if k % 200 == 150 else d,
    ],
)
def test_values_that_are_none_change_no_map(bad, tmp_path, capsys):
    code, right, _ = connect(tmp_path, HEAD + TIP + NAMED, press(), capsys)
    clean = (tmp_path / "hand.toml").read_text()
    frames = [bad(k, d) for k, d in enumerate(press())]
    again, told, _ = connect(tmp_path, HEAD + TIP + NAMED, frames, capsys)
    assert (code, again) == (0, 0)
    assert "invalid = [32767, 32766]" in clean
    was, now = parse_toml(clean)["fingers"]["thumb"], parse_toml((tmp_path / "hand.toml").read_text())
    for channel, keys in was.items():
        after = now["fingers"]["thumb"][channel]
        if isinstance(keys, dict):
            assert [keys.get(key) for key in SAME] == [after.get(key) for key in SAME]
            assert keys.get("zero", 0.0) == pytest.approx(after.get("zero", 0.0), rel=0.02, abs=1e-4)
    assert now["rate"] == 100.0
    largest = [one["values"]["thumb"]["normal_force"][2] for one in (told, right)]
    assert largest[0] == pytest.approx(largest[1], abs=1e-4)
    assert any("values are no measurement" in text for text in told["learned"])


def test_more_than_one_in_a_hundred_is_a_warning_and_a_tenth_is_refused_unless_accepted(tmp_path, capsys):
    for every, code, kind in ((50, 0, "vegrip: Finger1_State.Fz: 20 of 1000"), (5, 3, "200 of 1000")):
        frames = [data(32767) if k % every == 0 else d for k, d in enumerate(press())]
        done, told, err = connect(tmp_path, HEAD + TIP + NAMED, frames, capsys)
        assert done == code
        assert kind in err.splitlines()[0]
        assert told["lost"]
    assert connect(tmp_path, HEAD + TIP + NAMED, frames, capsys, "--accept-losses")[0] == 0
    option = ["--set", "fingers.thumb.normal_force.all_is_measured=true"]
    assert "Fz: 200" not in connect(tmp_path, HEAD + TIP + NAMED, frames, capsys, *option)[2]


@pytest.mark.parametrize("size", [2, 3, 6, 7])
def test_of_a_short_frame_the_signals_that_are_in_it_are_read(size, tmp_path):
    hand = codec(tmp_path)
    hand.decode_all(Frame(257, data(500, depth=900), False, 1))
    (state,) = hand.decode_all(Frame(257, data(705, depth=1000)[:size], False, 2))
    assert state.normal_force == 0.705
    assert state.displacement != state.displacement
    assert hand.rejected == {"length": 1}
    assert hand.decode_all(Frame(257, b"\1", False, 3)) == []


def test_a_frame_that_lacks_no_signal_is_not_short(tmp_path):
    eight = TIP.replace("Depth : 48|16@1- (1,0)", "Depth : 48|8@1- (10,0)")
    hand = codec(tmp_path, HEAD + eight)
    (state,) = hand.decode_all(Frame(257, data(705, depth=100)[:7], False, 2))
    assert (state.displacement, hand.rejected) == (pytest.approx(1e-3), {})


def test_big_endian_signals_of_a_short_frame_are_read_where_they_stand(tmp_path):
    big = TIP.replace("0|16@1-", "7|16@0-").replace("48|16@1-", "55|16@0-")
    hand = codec(tmp_path, HEAD + big)
    (state,) = hand.decode_all(Frame(257, (705).to_bytes(2, "big") + bytes(4), False, 2))
    assert state.normal_force == 0.705
    assert state.displacement != state.displacement


def test_pages_that_are_as_long_as_their_signals_are_read(tmp_path, capsys):
    pages = """BO_ 257 Tip1: 8 HAND
 SG_ Page M : 0|8@1+ (1,0) [0|15] "" HOST
 SG_ Fz m0 : 8|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Fx m0 : 24|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Fy m0 : 40|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Depth m1 : 8|16@1- (1,0) [-30000|30000] "um" HOST
"""
    frames = [part for d in press() for part in (b"\0" + d[:6], b"\1" + d[6:])]
    code, told, err = connect(tmp_path, HEAD + pages, frames, capsys)
    assert (code, err) == (0, "")
    assert set(told["values"]["thumb"]) >= {"normal_force", "displacement"}
    assert told["values"]["thumb"]["normal_force"][2] > 1.9


def test_frames_that_are_all_short_are_said_to_be_that(tmp_path, capsys):
    code, told, err = connect(tmp_path, HEAD + TIP, [d[:6] for d in press()], capsys)
    assert code == 3
    assert "1000 frames of Finger1_State are shorter than the 8 bytes" in err
    assert "missing from them: Depth" in err
    assert told["values"]["thumb"]["normal_force"][2] > 1.9


def test_frames_that_hold_no_signal_at_all_are_said_to_be_that(tmp_path, capsys):
    code, _, err = connect(tmp_path, HEAD + TIP, [d[:1] for d in press()], capsys)
    assert code == 3
    assert "1000 frames of Finger1_State came, which hold none of its signals: they have 1 bytes" in err


def test_a_short_message_that_nobody_needs_is_no_loss(tmp_path, capsys):
    signals = "".join(f' SG_ {n} : {at}|8@1+ (1,0) [0|0] "" HOST\n' for n, at in (("Code", 0), ("More", 48)))
    (tmp_path / "hand.dbc").write_text(f"{HEAD}{TIP}BO_ 258 Diag: 8 HAND\n{signals}")
    tips = log(tmp_path / "a.log", press()).read_text().splitlines()
    others = log(tmp_path / "b.log", [b"12"] * 1000, 258).read_text().splitlines()
    (tmp_path / "a.log").write_text("\n".join(f"{a}\n{b}" for a, b in zip(tips, others, strict=True)) + "\n")
    command = ["connect", str(tmp_path / "hand.dbc"), "--log", str(tmp_path / "a.log")]
    assert main([*command, "-o", str(tmp_path / "hand.toml")]) == 0
    assert capsys.readouterr().err == ""


def test_a_value_that_is_a_mark_is_named_with_the_option_though_no_database_names_it(tmp_path, capsys):
    frames = [data(32767) if k % 50 == 7 else d for k, d in enumerate(press())]
    _, told, _ = connect(tmp_path, HEAD + TIP.replace("[-30|30]", "[0|0]"), frames, capsys)
    assert any("--set 'fingers.thumb.normal_force.invalid=[32767]'" in text for text in told["lost"])


@pytest.mark.parametrize(
    ("change", "sentence", "expected"),
    [
        (
            lambda k, d: data(32767, depth=100) if 200 < k < 500 else d,
            "normal_force has no value in 299 of",
            3,
        ),
        (lambda k, d: data(32767, depth=100) if k % 50 == 7 else d, "normal_force has no value in 20 of", 0),
        (lambda _, d: d[:6], "displacement has no value in 1000 of 1000 states", 0),
    ],
)
def test_a_map_accounts_for_what_is_missing_in_a_log(change, sentence, expected, tmp_path, capsys):
    assert connect(tmp_path, HEAD + TIP + NAMED, press(), capsys)[0] == 0
    log(tmp_path / "a.log", [change(k, d) for k, d in enumerate(press())])
    command = ["connect", str(tmp_path / "hand.toml"), "--log", str(tmp_path / "a.log")]
    assert main(command) == expected
    assert sentence in capsys.readouterr().err
    assert main([*command, "--accept-losses"]) == 0


@pytest.mark.parametrize("silence", [1.5, 3600.0])
def test_a_silence_is_told_and_changes_no_rate(silence, tmp_path, capsys):
    (tmp_path / "hand.dbc").write_text(HEAD + TIP)
    lines = log(tmp_path / "a.log", press()).read_text().splitlines()
    later = [
        f"({1.7e9 + 0.01 * k + (silence if k >= 300 else 0.0):.6f}){line.partition(')')[2]}"
        for k, line in enumerate(lines)
    ]
    (tmp_path / "a.log").write_text("\n".join(later) + "\n")
    command = ["connect", str(tmp_path / "hand.dbc"), "--log", str(tmp_path / "a.log")]
    assert main([*command, "-o", str(tmp_path / "hand.toml")]) == 0
    assert f"nothing of thumb came from 2.99 to {3 + silence:.6g} s" in capsys.readouterr().err
    assert parse_toml((tmp_path / "hand.toml").read_text())["rate"] == pytest.approx(100.0, rel=0.01)


FLAGS = ' SG_ Code : 0|8@1+ (1,0) [0|255] "" HOST\n SG_ Hot : 0|1@1+ (1,0) [0|1] "" HOST\n'


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (f"\nBO_ 300 Status: 2 HAND\n{FLAGS}", "Status"),
        ('\nBO_ 301 Info: 2 HAND\n SG_ Serial : 0|32@1+ (1,0) [0|0] "" HOST\n', "Info"),
        (
            '\nBO_ 419365121 Diag: 8 HAND\n SG_ Code : 0|8@1+ (1,0) [0|0] "" HOST\n',
            "Diag: 0x18FF",
        ),
    ],
)
def test_a_message_that_cannot_be_is_left_out_and_named(more, why, tmp_path, capsys):
    code, told, _ = connect(tmp_path, HEAD + TIP + more, press(), capsys)
    assert code == 0
    assert any(text.startswith("left out: ") and why.split(":")[0] in text for text in told["open"])


def test_a_database_of_nothing_else_is_refused(tmp_path):
    (tmp_path / "a.dbc").write_text(f"{HEAD}BO_ 300 Status: 2 HAND\n{FLAGS}")
    with pytest.raises(ConfigError, match="cannot be read as a CAN database"):
        read_dbc(tmp_path / "a.dbc")


def test_two_messages_of_one_name_are_told_apart(tmp_path):
    twice = TIP + "\n" + TIP.replace("257", "258")
    (tmp_path / "a.dbc").write_text(HEAD + twice)
    assert set(read_dbc(tmp_path / "a.dbc").messages) == {"Finger1_State_101", "Finger1_State_102"}


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "utf-8-sig", "utf-16"])
def test_the_encoding_of_a_database_does_not_change_its_units(encoding, tmp_path):
    (tmp_path / "a.dbc").write_text(HEAD + TIP.replace('"um"', '"µm"'), encoding=encoding)
    assert read_dbc(tmp_path / "a.dbc").signal("Finger1_State.Depth").unit == "µm"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Kraft_längs_Fx", ["kraft", "laengs", "fx"]),
        ("Kraft_rückwärts", ["kraft", "rueckwaerts"]),
        ("Kraft_la\u0308ngs", ["kraft", "laengs"]),
        ("Force_avancée_l", ["force", "avancee", "l"]),
    ],
)
def test_letters_with_marks_make_no_words_of_their_own(name, words):
    assert words_of(name) == words


@pytest.mark.parametrize("name", ["Kraft_längs_Fx", "Kraft_rückwärts_Fx", "Größe_Fz"])
def test_no_finger_is_made_of_the_letter_before_an_umlaut(name):
    assert finger_of("Tip", name, ()) == ""


def test_a_key_that_was_said_is_changed_by_saying_it_again_and_by_no_traffic():
    draft = Draft({})
    draft.set("zero", 1.0, "the mean at rest")
    draft.set("zero", 2.0)
    draft.set("zero", 3.0, "the mean at rest")
    assert (draft.keys, draft.notes) == ({"zero": 2.0}, {"zero": BY_USER})
    draft.set("zero", 4.0)
    assert draft.keys == {"zero": 4.0}


def test_a_finger_whose_sign_was_said_is_not_turned_round_as_another_one_was():
    turned = Draft({"sign": -1}, {"sign": "a press is positive", "seen": "a press is positive"})
    fingers = {"thumb": turned, "index": Draft({"sign": 1}, {"sign": BY_USER}), "middle": Draft({})}
    drafts = {name: FingerDraft({"normal_force": draft}) for name, draft in fingers.items()}
    proposal = Proposal("hand.dbc", drafts)
    learn(proposal, {}, {}, Database("hand.dbc", {}))
    assert {name: draft.keys["sign"] for name, draft in fingers.items()} == {
        "thumb": -1, "index": 1, "middle": -1,
    }  # fmt: skip
    assert proposal.learned == ["middle: normal_force turned round as at thumb"]
