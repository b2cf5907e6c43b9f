"""Every map that cannot be is refused in one sentence that says where and what to do."""

import pytest

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, written
from vegrip.errors import ConfigError
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan

SECOND = '\n[fingers.index.normal_force]\nsignal = "Tip1.Fz"\n'
HEAD = "[fingers.thumb.normal_force]"
FZ = 'signal = "Tip1.Fz"'

BAD = {
    "no signal": (
        "Tip1.Fz",
        "Tip1.Fzz",
        "Tip1 has no signal 'Fzz'; it has Fz, Fx, Fy, Cnt, Crc; did you mean Fz?",
    ),
    "no message": ("Tip1.Fz", "Tip9.Fz", "did you mean Tip1?"),
    "no dot": ("Tip1.Fz", "Fz", "must be MESSAGE.SIGNAL"),
    "a unit of another quantity": (
        FZ,
        FZ + '\nunit = "mm"',
        "'mm' is not a unit of this quantity; it needs one like N",
    ),
    "no unit": (FZ, FZ + '\nunit = "foobar"', "there is no unit 'foobar'"),
    "one signal for two fingers": (PLAIN_MAP, PLAIN_MAP + SECOND, "already the normal_force of thumb"),
    "one signal for two channels": ("Tip1.Fx", "Tip1.Fz", "is already the normal_force of thumb"),
    "unknown channel": ("fingers.thumb.torque_z", "fingers.thumb.torqe_z", "did you mean torque_z?"),
    "unknown key": (FZ, FZ + "\nsing = -1", "unknown key 'sing'; did you mean sign?"),
    "sign": (FZ, FZ + "\nsign = 2", "it must be 1 or -1"),
    "no source": (FZ, 'unit = "N"', "give one of 'signal', 'signals' and 'stated', not none of them"),
    "two sources": (FZ, FZ + '\nstated = "1 N"', "not 'signal' and 'stated'"),
    "weights": (FZ, FZ + "\nweights = [1.0, 2.0]", "'weights' has 2 numbers for 1 signals"),
    "table": (FZ, FZ + "\ntable = [[1, 2], [0, 3]]", "must ascend"),
    "table of one": (FZ, FZ + "\ntable = [[1, 2]]", "must be two or more pairs"),
    "gain": (FZ, FZ + '\ngain = "2.5 mm"', "'gain'"),
    "gain without a number": (FZ, FZ + '\ngain = "much"', "must be a number and a unit"),
    "trigger": (
        HEAD,
        '[fingers.thumb]\ntrigger = "Set1"\n[fingers.thumb.normal_force]',
        "the trigger Set1 carries no channel",
    ),
    "mirror": (
        HEAD,
        '[fingers.thumb]\naxes = ["y", "x", "z"]\n[fingers.thumb.normal_force]',
        "this is a mirror image",
    ),
    "axes": (
        HEAD,
        '[fingers.thumb]\naxes = ["y", "x", "w"]\n[fingers.thumb.normal_force]',
        "it must be x, y or z",
    ),
    "rotation": (HEAD, "[fingers.thumb]\nrotation = [[1,0,0],[0,1,0],[0,1,1]]\n" + HEAD, "at right angles"),
    "both databases": ("rate = 200.0", 'format = "json"', "only one of them"),
    "no file": ("plain.dbc", "other.dbc", "there is no such file; 'database' is relative to the map"),
    "counter": ('counter = "Cnt"\nchecksum', 'counter = "Count"\nchecksum', "Tip1 has no signal 'Count'"),
    "checksum": (
        'signal = "Crc", polynomial',
        'signal = "Crk", polynomial',
        "must be the signal of Tip1 with the checksum",
    ),
    "message of the map": ("[messages.Set1]", "[messages.Sett]", "did you mean Set1?"),
    "kind": (
        'signal = "Set1.Grip"',
        'signal = "Set1.Grip"\nkind = "pull"',
        "must be one of force, increment",
    ),
    "position without stiffness": (
        'signal = "Set1.Grip"',
        'signal = "Set1.Grip"\nkind = "position"',
        "needs 'stiffness'",
    ),
    "set": ("Enable = 1", "Enabel = 1", "did you mean Enable?"),
    "nodes": ("rate = 200.0", "nodes = { thumb = 1 }", "'nodes' belongs to an .eds"),
    "a condition on CAN": (
        "rate = 200.0",
        'rate = 200.0\n[conditions.hot]\nwhere = { "Tip1.Cnt" = 1 }',
        "are of devices on UDP, TCP or a serial line",
    ),
    "ready on CAN": ("rate = 200.0", 'device.ready = "hot"', "are of devices on UDP, TCP or a serial line"),
    "an entry until something on CAN": (
        "rate = 200.0",
        'device.opening = [{ identifier = 1, data = "00", until = "hot" }]',
        "are of devices on UDP, TCP or a serial line",
    ),
    "too old": (HEAD, "[fingers.thumb]\nmax_age = -1.0\n" + HEAD, "must lie in 0 .. 10 s"),
    "no unit of an angle": (
        '[fingers.thumb.tangential_force_x]\nsignal = "Tip1.Fx"',
        '[fingers.thumb.tangential_direction]\nsignal = "Tip1.Cnt"',
        "nothing says the unit of this angle",
    ),
    "no table": (
        "[fingers.thumb.normal_force]\n" + FZ,
        "[fingers.thumb]\nnormal_force = 3",
        "it must be a table",
    ),
    "no taxel": (
        "[fingers.thumb.normal_force]\n" + FZ,
        "[fingers.thumb.taxels]\nnormal = []",
        "'normal' names no taxel",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_map_that_cannot_be_is_refused_in_a_sentence(tmp_path, name):
    before, after, said = BAD[name]
    assert before in PLAIN_MAP
    path = written(tmp_path, PLAIN_DBC, PLAIN_MAP.replace(before, after, 1))
    with pytest.raises(ConfigError) as refused:
        MappedCodec(open_plan(path))
    assert said in str(refused.value)
    assert str(refused.value).startswith(str(tmp_path))
    assert "\n" not in str(refused.value)


def test_a_finger_that_is_not_mapped_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"there is no \[fingers.ring\]; mapped are thumb"):
        open_plan(written(tmp_path, PLAIN_DBC, PLAIN_MAP), ("ring",))


@pytest.mark.parametrize(
    "text", ["", "VERSION", "\x00\xff" * 50, 'BO_ 1 A: 8 X\n SG_ a : 0|99@1+ (1,0) [0|0] "" X']
)
def test_a_database_that_is_none_is_refused(tmp_path, text):
    with pytest.raises(ConfigError, match=r"plain\.dbc: (cannot be read|declares no)"):
        open_plan(written(tmp_path, text, PLAIN_MAP))
