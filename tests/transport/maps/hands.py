"""Made-up hands for the tests: a database, a map, and the device that speaks so."""

import random
from pathlib import Path

import cantools.database

PLAIN_DBC = """VERSION ""
NS_ :
BS_:
BU_: Hand
BO_ 256 Tip1: 8 Hand
 SG_ Fz : 0|16@1- (0.01,0) [-300|300] "N" X
 SG_ Fx : 16|16@1- (0.01,0) [-300|300] "N" X
 SG_ Fy : 32|16@1- (0.01,0) [-300|300] "N" X
 SG_ Cnt : 48|4@1+ (1,0) [0|15] "" X
 SG_ Crc : 56|8@1+ (1,0) [0|255] "" X
BO_ 272 Pos1: 8 Hand
 SG_ Depth : 7|16@0- (0.001,0) [-32|32] "mm" X
 SG_ Tz : 16|16@1- (0.0001,0) [-3|3] "Nm" X
 SG_ Slip : 32|1@1+ (1,0) [0|1] "" X
BO_ 512 Set1: 8 X
 SG_ Grip : 0|16@1+ (0.01,0) [0|50] "N" Hand
 SG_ Enable : 16|1@1+ (1,0) [0|1] "" Hand
 SG_ Cnt : 48|4@1+ (1,0) [0|15] "" Hand
 SG_ Crc : 56|8@1+ (1,0) [0|255] "" Hand
"""

PLAIN_MAP = """
database = "plain.dbc"
rate = 200.0

[messages.Tip1]
counter = "Cnt"
checksum = { kind = "crc8", signal = "Crc", polynomial = 0x2F, start = 0xFF, final = 0xFF }

[messages.Set1]
counter = "Cnt"
checksum = { kind = "crc8", signal = "Crc", polynomial = 0x2F, start = 0xFF, final = 0xFF }

[fingers.thumb.normal_force]
signal = "Tip1.Fz"
[fingers.thumb.tangential_force_x]
signal = "Tip1.Fx"
[fingers.thumb.tangential_force_y]
signal = "Tip1.Fy"
[fingers.thumb.displacement]
signal = "Pos1.Depth"
[fingers.thumb.torque_z]
signal = "Pos1.Tz"

[fingers.thumb.command]
signal = "Set1.Grip"
set = { Enable = 1 }
"""


def written(folder: Path, dbc: str, text: str, name: str = "plain.dbc") -> Path:
    """Write a database and its map; return the path of the map."""
    (folder / name).write_text(dbc)
    path = folder / "hand.toml"
    path.write_text(text)
    return path


def load(dbc: str) -> cantools.database.can.Database:
    """Return the database as cantools has it: the independent way to make frames and read them."""
    return cantools.database.load_string(dbc, "dbc")


def seeded(seed: int) -> random.Random:
    """Return random numbers that are the same in every run."""
    return random.Random(seed)  # noqa: S311
