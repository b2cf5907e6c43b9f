"""A model that cannot work is refused where it is built, by the name of the effect and with the remedy."""

import math
import re
from pathlib import Path

import pytest

from vegrip.effects import Effect, State, effect, hook, names
from vegrip.errors import ModelError
from vegrip.estimator import compiled
from vegrip.estimator.layout import layout_of
from vegrip.model import BASE, ContactModel, paper_model
from vegrip.parameters import Parameter, declared

MODEL = paper_model(8e-3)


def built(*effects: Effect) -> ContactModel:
    values = {p.symbol: declared(p) for e in effects for p in e.parameters}
    return ContactModel(effects, values, 8e-3, 8e-4)


def base(*left_out: str) -> list[Effect]:
    return [effect(name) for name in BASE if name not in left_out]


def one(function: object, **declarations: object) -> Effect:
    hooked = hook(function, **{k: declarations.pop(k) for k in ("stage", "gives") if k in declarations})  # type: ignore[arg-type]
    return Effect("mine", "a test", (), (hooked,), **declarations)  # type: ignore[arg-type]


def elastic(x: float) -> float:
    return max(x, 0.0)


def test_two_definitions_of_a_quantity_are_refused() -> None:
    with pytest.raises(ModelError, match="power_law_stiffness and mine both define elastic_force"):
        built(*base(), one(elastic))


def test_a_missing_definition_is_named() -> None:
    with pytest.raises(ModelError, match="no effect defines friction"):
        built(*base("coulomb_friction"))


def test_an_unknown_argument_is_named_with_what_there_is() -> None:
    def force(force: float, colour: float) -> float:
        return force + colour

    with pytest.raises(ModelError, match=r"mine uses 'colour', .* stage force.*elastic_force"):
        built(*base(), one(force))


def test_a_quantity_that_is_not_known_yet_is_refused() -> None:
    def tip(x: float, force: float) -> float:
        return x - force

    with pytest.raises(ModelError, match="mine uses force at the stage tip"):
        built(*base(), one(tip))


def test_changing_a_quantity_after_its_use_names_the_order() -> None:
    def force(relaxation_rate: float, x: float) -> float:
        return relaxation_rate / (1.0 + max(x, 0.0))

    late = one(force, gives="relaxation_rate")
    with pytest.raises(ModelError, match="put mine before relaxation"):
        built(*base(), late)
    stiffness, *others = base()
    assert built(stiffness, late, *others)


def test_symbols_have_one_owner() -> None:
    def force(force: float, K: float) -> float:
        return force * K

    again = one(force, parameters=(Parameter("K", "1", 1.0, 0.1, 0.0, 2.0, "again"),))
    with pytest.raises(ModelError, match="power_law_stiffness and mine both have 'K'"):
        built(*base(), again)


def test_an_effect_that_returns_nan_is_named_with_the_point() -> None:
    def force(force: float, x: float) -> float:
        return force if x >= 0.0 else math.nan

    with pytest.raises(ModelError, match=r"mine gives force = nan at force with .*x = -0.0004"):
        built(*base(), one(force))


def test_an_effect_that_fails_is_named() -> None:
    def force(force: float, x: float) -> float:
        return force + math.sqrt(x)

    with pytest.raises(ModelError, match="mine fails at force"):
        built(*base(), one(force))


def test_the_wrong_number_of_values_is_named() -> None:
    def force(force: float, memory: float) -> float:
        return force + memory

    with pytest.raises(ModelError, match="returns 1 values at force; it must return force, memory"):
        built(*base(), one(force, states=(State("memory", "N", "a test"),)))


def test_a_hook_may_use_nothing_but_math_and_its_own() -> None:
    def force(force: float) -> float:
        return float(re.escape("") == "") * force

    with pytest.raises(ModelError, match="uses 're'"):
        built(*base(), one(force))


@pytest.mark.parametrize("value", [-1.0, 0.0, math.nan, 1e30])
def test_a_value_out_of_bounds_is_refused(value: float) -> None:
    with pytest.raises(ModelError, match="power_law_stiffness: K is"):
        MODEL.with_value("K", value)


def test_an_unknown_effect_lists_the_known() -> None:
    with pytest.raises(ModelError, match=r"no effect 'stickiness'; there are .*power_law_stiffness"):
        effect("stickiness")
    assert set(BASE) <= set(names())


def test_a_users_effect_from_a_source_text_runs() -> None:
    """Functions made by exec have no file; their text is given."""
    text = "def force(force, q1):\n    return force * (1.0 - q1)\n"
    scope: dict[str, object] = {}
    exec(text, scope)  # noqa: S102
    made = hook(scope["force"], source=text)  # type: ignore[arg-type]
    half = Effect(
        "half", "a test", (), (made,), parameters=(Parameter("q1", "1", 0.5, 0.1, 0.0, 1.0, "less"),)
    )
    whole = MODEL.simulate([0.0, 0.1], [0.0, 1e-3]).normal_force[-1]
    assert built(*base(), half).with_value("K", MODEL.values["K"].value).simulate(
        [0.0, 0.1], [0.0, 1e-3]
    ).normal_force[-1] == pytest.approx(0.5 * whole)


def test_comments_and_docstrings_do_not_change_the_compiled_module() -> None:
    def same(x: float) -> float:
        """Another text."""
        # and a comment
        return max(x, 0.0)

    same.__name__ = same.__qualname__ = "elastic"
    first, second = (
        built(
            one(f, stage="elastic"),
            *base("power_law_stiffness", "relaxation", "pressure_coupling"),
            effect("relaxation"),
            effect("pressure_coupling"),
        )
        for f in (elastic, same)
    )
    assert first.source() == second.source()


ONE = '"""Of the first kernel."""\n\nFAR = 25.0\n\ndef reach(m):\n    return FAR\n'


@pytest.mark.parametrize(
    ("other", "name"),
    [
        ('"""Of the second."""\n\nFAR = 9.0\n', "FAR"),
        ('"""Of the second."""\n\nNEAR, FAR = 1.0, 9.0\n', "FAR"),
        ('"""Of the second."""\n\nFAR: float = 9.0\n', "FAR"),
        ('"""Of the second."""\n\ndef reach(m):\n    return 0.0\n', "reach"),
        ('"""Of the second."""\n\ndef advance(m):\n    return 0.0\n', "advance"),
    ],
)
def test_two_kernels_that_define_the_same_name_are_refused(other: str, name: str) -> None:
    with pytest.raises(ModelError, match=rf"^{name} is defined in two texts .*'Of the second\.'; rename one"):
        paper_model(8e-3).source([ONE, other])


def test_a_declaration_without_a_value_and_a_name_within_a_function_clash_with_nothing() -> None:
    other = "FAR: float\n\ndef other(m):\n    FAR = 1.0\n    return FAR\n"
    assert "def other(m):" in paper_model(8e-3).source([ONE, other])


def test_a_kernel_file_that_takes_a_name_of_another_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    model = paper_model(8e-3)
    real = Path.read_text

    def with_a_clash(path: Path, **how: str) -> str:
        text = real(path, **how)
        return text + "\nGATE = 1.0\n" if path.name == f"{compiled.KERNELS[0]}.py" else text

    monkeypatch.setattr(Path, "read_text", with_a_clash)
    compiled._text.cache_clear()
    with pytest.raises(ModelError, match="GATE is defined in two texts"):
        compiled.text_of(model, layout_of(model))
    compiled._text.cache_clear()
