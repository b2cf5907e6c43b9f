"""A package for an effect of one's own: what ``vegrip new-effect`` writes.

It is complete and works as it is: a second contact spot, which the author replaces by his own law.
"""

import keyword
from pathlib import Path
from string import Template

from vegrip.effects import names
from vegrip.errors import InputError, UsageError
from vegrip.whole_file import write_whole, writing

PYPROJECT = """\
[build-system]
requires = ["setuptools>=77"]
build-backend = "setuptools.build_meta"

[project]
name = "vegrip-$dashed"
version = "0.1.0"
description = "The effect $name for vegrip"
requires-python = ">=3.11"
dependencies = ["vegrip"]

[project.entry-points."vegrip.effects"]
$name = "vegrip_$name:EFFECT"

[tool.setuptools]
py-modules = ["vegrip_$name"]
"""

EFFECT = '''\
"""A second spot of the fingertip touches at the depth x_s: ``N_e += s_s K ((x - x_s) / x_ref)^(3/2)``.

Replace this by your own law: its equation, what it assumes, where it comes from. Forces in units of K (the
elastic force at the reference depth ``x_ref = R / 10``) and depths in x_ref serve fingertips of any size.
"""

from vegrip.effects import Effect, hook
from vegrip.parameters import Parameter


def elastic(
    elastic_force: float, x: float, reference_depth: float, K: float, s_s: float, x_s: float
) -> float:
    """Return the elastic force [N].

    A hook is scalar Python with nothing but math, numbers and functions of this file. It takes what it
    needs by the names of its arguments; `vegrip/effects/contract.py` lists stages and names.
    """
    beyond = max(x / reference_depth - x_s, 0.0)
    return elastic_force + s_s * K * beyond**1.5


EFFECT = Effect(
    name="$name",
    summary="another part of the fingertip touches when it is pressed in deeper",
    cites=("own",),
    parameters=(
        # symbol, unit, default, std of the prior, lower and upper bound, what it is; null: where it is absent
        Parameter("s_s", "1", 0.5, 0.5, 0.0, 100.0, "stiffness of the second spot over K", null=0.0),
        Parameter("x_s", "1", 1.2, 0.5, 0.0, 20.0, "depth at which it touches, in x_ref"),
    ),
    hooks=(hook(elastic),),
    confounded=("second_contact", "layer_over_core"),
    experiment="slow press to beyond the depth at which the spot touches",
)
'''

TEST = '''\
"""The effect holds to the laws of every effect, and to one of its own."""

import numpy as np
from vegrip_$name import EFFECT

from vegrip.model import paper_model
from vegrip.model.laws import broken_laws


def test_no_law_is_broken():
    assert broken_laws(EFFECT) == []


def test_above_the_second_spot_nothing_changes():
    base = paper_model(8e-3)
    model = base.with_effect(EFFECT)
    t = np.linspace(0.0, 1.0, 200)
    depth = 1.1 * base.reference_depth * t
    np.testing.assert_array_equal(model.simulate(t, depth).normal_force, base.simulate(t, depth).normal_force)
'''

README = """\
# $name

An effect for vegrip. `pip install .` makes it known:

    python -m pytest
    vegrip diagnose RECORDING                  # may now name it
    vegrip add $name RECORDING -o model.toml   # adds it to the model
"""

FILES = {
    "pyproject.toml": PYPROJECT,
    "vegrip_$name.py": EFFECT,
    "tests/test_$name.py": TEST,
    "README.md": README,
}


def write_package(name: str, folder: Path, *, replace: bool = False) -> list[Path]:
    """Write the package of the effect ``name`` to ``folder``; return the files."""
    if not name.isidentifier() or keyword.iskeyword(name) or name != name.lower():
        raise UsageError(
            f"{name!r} cannot name an effect; take small letters, digits and _, as in lateral_give"
        )
    if name in names():
        raise UsageError(f"there is an effect {name!r} already; choose another name")
    if folder.is_file():
        raise InputError(f"{folder}: is a file; give another folder with -o")
    if folder.exists() and any(folder.iterdir()) and not replace:
        raise InputError(
            f"{folder} is not empty; give another folder with -o, or --force to replace its files"
        )
    written = []
    for path, text in FILES.items():
        target = folder / Template(path).substitute(name=name)
        with writing(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            write_whole(target, Template(text).substitute(name=name, dashed=name.replace("_", "-")))
        written.append(target)
    return written
