"""Whoever types options is told options: no refusal of theirs speaks of the sections of a file."""

import re
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main

T = 0.01 * np.arange(300)
DEPTH = np.interp(T, [0.0, 0.4, 1.5, 2.6, 3.0], [0.0, 0.0, 1.0, 0.0, 0.0])
DBC = """VERSION ""

NS_ :

BS_:

BU_: HAND HOST

BO_ 257 Finger1_State: 8 HAND
 SG_ Fz : 0|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Fx : 16|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Fy : 32|16@1- (0.001,0) [-30|30] "N" HOST
 SG_ Depth : 48|16@1- (1,0) [-30000|30000] "um" HOST
"""
MAPPED = "--map t=t --map displacement=d --unit displacement=mm --map normal_force=f --unit normal_force=mN"
SECTION = re.compile(r"\[+[a-z_]+(\.[\w.*]+)?\]")


@pytest.fixture
def inputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    rows = [(f"{a:.2f}", f"{b:.4f}", f"{1200 * b**1.5:.1f}") for a, b in zip(T, DEPTH, strict=True)]
    for name, between, all_rows in (("a", ",", rows), ("spaces", "   ", rows), ("twice", ",", rows + rows)):
        lines = [between.join("tdf"), *(between.join(row) for row in all_rows)]
        Path(f"{name}.csv").write_text("\n".join(lines) + "\n")
    bad = [row if k % 3 else (row[0], row[1], "OL") for k, row in enumerate(rows)]
    Path("lost.csv").write_text("\n".join(["t,d,f", *(",".join(row) for row in bad)]) + "\n")
    Path("h.dbc").write_text(DBC)
    Path("e.eds").write_text("[DeviceInfo]\n")
    for name, channels in (("one", ("can0",)), ("two", ("can0", "can1"))):
        frames = [
            f"({1.7e9 + 0.01 * k:.6f}) {channel} 101#{round(1200 * b**1.5).to_bytes(2, 'little').hex()}0000"
            f"1400{round(1000 * b).to_bytes(2, 'little').hex()}"
            for k, b in enumerate(DEPTH)
            for channel in channels
        ]
        Path(f"{name}.log").write_text("\n".join(frames) + "\n")
    assert main(["import", "a.csv", "-o", "norad", *MAPPED.split()]) == 0
    return tmp_path


OF_IMPORT = {
    "spaces.csv MAP": "--delimiter",
    "twice.csv MAP": "--map episode=COLUMN",
    "lost.csv MAP": "--accept-losses",
    "a.csv": "--map normal_force=COLUMN",
    "a.csv --map t=time --map normal_force=f": "--map t=COLUMN",
    "a.csv --map foo": "--map normal_force=force_N",
    "a.csv MAP --zero displacement=contact": "--baseline SECONDS",
    "a.csv MAP --zero displacement=baseline": "--baseline SECONDS",
    "a.csv MAP --zero displacement=foo": "--zero displacement=foo",
    "a.csv MAP --unit normal_force=furlong": "one like N",
    "a.csv MAP --radius 8furlong": "--radius",
    "a.csv MAP --decimal x": "--decimal",
    "a.csv MAP --step": "--map modulus=COLUMN",
    "two.log": "--channel can0",
    "one.log MAP": "--map does not apply",
}
OF_CONNECT = {
    "h.dbc --log two.log": "--channel can0",
    "e.eds --log one.log": "--nodes thumb=32,index=33",
    "h.dbc --log one.log --rest 5": "--rest",
    "h.dbc --log one.log --press 20..30": "--press",
    "h.dbc --log one.log --set foo": "--set",
    "h.dbc --log one.log --set foo.bar=1": "--set",
    "h.dbc --log one.log --set rate=-5": "--set",
    "h.dbc --log one.log --set fingers.thumb.max_age=99": "--set fingers.thumb",
    "h.dbc --log one.log --set fingers.thumb.trigger=Foo": "--set fingers.thumb",
    "h.dbc --log one.log --set fingers.thumb.normal_force.sgn=1": "--set fingers.thumb.normal_force",
    "h.dbc --log one.log --set fingers.thumb.normal_force.signal=Foo.Bar": "--set fingers.thumb.normal_force",
    "h.dbc --log one.log --set messages.Finger1_State.counter=Foo": "--set messages.Finger1_State",
    "h.dbc --log one.log --rest 0..0.3 --press 0.4..2.6 --set fingers.thumb.displacement.sign=-1": "--set",
}
OTHERS = {
    "fit norad": "--radius",
    "diagnose norad": "--radius",
    "compare norad": "--radius",
    "report norad -o r.html": "--radius",
    "calibrate two.log --weight 0.5": "--channel can0",
    "calibrate --weight 0.5": "--node",
    "replay one.log": "--map",
}
ALL = {f"import {k} -o r": v for k, v in OF_IMPORT.items()}
ALL |= {f"connect {k} -o hand.toml": v for k, v in OF_CONNECT.items()}


@pytest.mark.parametrize(("typed", "told"), (ALL | OTHERS).items())
def test_a_refusal_of_options_names_options_and_no_section_of_a_file(typed, told, inputs, capsys):
    capsys.readouterr()
    assert main(typed.replace("MAP", MAPPED).split()) in (2, 3)
    err = capsys.readouterr().err
    assert told in err
    assert not SECTION.search(err), err
    assert "hand.toml" not in err


def test_whoever_wrote_a_file_is_told_its_keys(inputs, capsys):
    Path("map.toml").write_text('[time]\ncolumn = "t"\n[channels.normal_force]\ncolumn = "f"\n')
    assert main(["import", "spaces.csv", "-o", "r", "--map-file", "map.toml"]) == 3
    assert '[table] delimiter = " "' in capsys.readouterr().err
    Path("hand.toml").write_text('database = "h.dbc"\n[fingers.thumb]\nmax_age = 99\n')
    assert main(["connect", "hand.toml", "--log", "one.log"]) == 3
    assert "hand.toml [fingers.thumb]: 'max_age' is 99" in capsys.readouterr().err
