"""An effect in a file is nothing but an effect: whatever else it holds is refused before it runs."""

from pathlib import Path

import pytest

from vegrip.effects import effect
from vegrip.effects.file import MAX_BYTES, effect_of
from vegrip.errors import InputError, ModelError
from vegrip.identification.samples import SAMPLES

GOOD = """
import math
from vegrip.effects import Effect, hook
from vegrip.parameters import Parameter

def force(force: float, a: float) -> float:
    return force * (1.0 + a * math.tanh(force))

EFFECT = Effect(name="mine", summary="more", cites=("own",), hooks=(hook(force),),
                parameters=(Parameter("a", "1", 0.1, 0.1, 0.0, 1.0, "amount", null=0.0),))
"""
BODY = "    return force * (1.0 + a * math.tanh(force))\n"


def test_a_plain_effect_is_read() -> None:
    assert effect_of(GOOD, "mine.py").name == "mine"


def test_the_sample_is_an_effect(tmp_path: Path) -> None:
    SAMPLES["tiring.py"].write(tmp_path / "tiring.py")
    found = effect(str(tmp_path / "tiring.py"))
    assert (found.name, found.file) == ("tiring", str(tmp_path / "tiring.py"))


@pytest.mark.parametrize(
    "text",
    [
        "import os\n" + GOOD,
        "from os import system\n" + GOOD,
        "import math as m\n" + GOOD,
        "from vegrip.effects import file\n" + GOOD,
        GOOD + "\nopen('x', 'w')\n",
        GOOD + "\nX = 9 ** 9 ** 9\n",
        GOOD + "\nwhile True: pass\n",
        GOOD + "\nclass A: pass\n",
        GOOD + "\nEFFECT.name\n",
        GOOD.replace(BODY, "    return math.__loader__\n"),
        GOOD.replace(BODY, "    return force.real\n"),
        GOOD.replace(BODY, "    return (lambda: 1)()\n"),
        GOOD.replace(BODY, "    return __import__('os')\n"),
        GOOD.replace(BODY, "    math = Effect\n    return force\n"),
        GOOD.replace(BODY, "    import os\n    return force\n"),
        GOOD.replace("def force", "@hook\ndef force"),
        GOOD.replace("EFFECT =", "OTHER ="),
        GOOD + "#" * MAX_BYTES,
        "def (",
        "x = " + "(" * 500,
        "",
    ],
)
def test_more_than_an_effect_is_refused_in_one_sentence(text: str) -> None:
    with pytest.raises(ModelError) as refused:
        effect_of(text, "mine.py")
    assert str(refused.value).startswith("mine.py: ")
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        effect(str(tmp_path / "none.py"))
