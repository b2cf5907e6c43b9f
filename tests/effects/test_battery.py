"""Laws that hold for every effect of the catalogue, whatever it describes.

Effects of other packages are theirs to test (``vegrip test-effect``): what is installed here must not matter.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

import vegrip
from vegrip.effects import BUILT_IN, effect
from vegrip.effects.contract import INPUTS
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import BASE
from vegrip.model.composer import compose
from vegrip.parameters import coordinate
from vegrip.web.report.bibtex import references

ADDED = [name for name in BUILT_IN if name not in BASE]
COLUMNS = ("x", "elastic_force", "force", "sensed_force", "contact_radius", "exponent", "friction")


@pytest.mark.parametrize("name", ADDED)
def test_compiled_and_uncompiled_are_the_same(name, model_with, rich):
    """The forces to the last bit; k not, whose gamma functions numba has of its own."""
    model, motion = model_with(name), rich.first(1000)
    fast, slow = motion.through(model), motion.through(model, plain=True)
    for column in ("indentation", "elastic_force", "normal_force", "sensed_force"):
        np.testing.assert_array_equal(getattr(fast, column), getattr(slow, column), err_msg=column)
    for column in ("contact_radius", "friction_coefficient"):
        np.testing.assert_array_max_ulp(getattr(fast, column), getattr(slow, column), maxulp=2)
    np.testing.assert_allclose(fast.pressure_exponent, slow.pressure_exponent, rtol=1e-11)


@pytest.mark.parametrize("corner", ["default", "low", "high"])
@pytest.mark.parametrize("name", ["relaxation", *ADDED])
def test_output_is_finite_for_any_bounded_input(name, corner, model_with):
    """Deep in, far out, at rest, torn away, in no time and after days; parameters at their bounds."""
    model = model_with(name)
    if corner != "default":
        for p in effect(name).parameters:
            model = model.with_value(p.symbol, getattr(p, corner))
    t, inputs = hostile(model, 2000)
    for plain, n in ((False, 2000), (True, 300)):
        out = np.empty((n, 7))
        model.compiled(plain=plain).run(model.vector, model.initial_states, t[:n], inputs[:n], out)
        assert np.isfinite(out).all(), f"{COLUMNS[int(np.argmin(np.isfinite(out).all(axis=0)))]}"
        assert (out[:, 4] >= 0.0).all()
        assert (out[:, 6] > 0.0).all()


def hostile(model, n):
    rng = np.random.default_rng(7)
    x, K = model.reference_depth, model.values["K"].value
    t = np.cumsum(rng.choice([0.0, 1e-9, 1e-3, 1.0, 1e5], n))
    of = {
        "delta": x * rng.choice([-1e3, -1.0, -1e-9, 0.0, 1e-9, 0.5, 2.0, 10.0, 1e3], n),
        "speed": x * rng.choice([-1e5, -1.0, 0.0, 1e-9, 1.0, 1e5], n),
        "temperature": rng.choice([-200.0, 0.0, 23.0, 60.0, 500.0], n),
        "tangential_force": K * rng.choice([0.0, 1.0, 1e3], n),
        "torque": K * x * rng.choice([-1e3, 0.0, 1e3], n),
        "slip_speed": x * rng.choice([0.0, 1e-6, 1.0, 1e4], n),
        "tangential_force_x": K * rng.choice([-1e3, 0.0, 1e3], n),
        "tangential_force_y": K * rng.choice([-1e3, 0.0, 1e3], n),
    }
    return t, np.ascontiguousarray(np.stack([of[name] for name in INPUTS], axis=1))


@pytest.mark.parametrize("name", ["relaxation", *ADDED])
def test_reading_the_present_state_changes_nothing(name, model_with, rich):
    """A step of no length, from the states it has itself given, gives force and states again."""
    model = model_with(name)
    module = model.compiled()
    for n in (90, 300, 522, 700, 1290, 1450, 2010, 2450, 3390, 3900):
        motion = rich.first(n)
        states, out = model.initial_states, np.empty((n, 7))
        inputs = motion.inputs()
        module.run(model.vector, states, motion.t, inputs, out)
        kept, again = states.copy(), np.empty((1, 7))
        module.run(model.vector, states, motion.t[-1:], inputs[-1:], again)
        np.testing.assert_allclose(again[0, :4], lifted(out[-1, :4], again[0, :4]), rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(states, kept, rtol=1e-12, atol=1e-15)


def lifted(before, after):
    """Where the surface had lifted off, its force is zero and what it would have been elastic is open."""
    return np.where([False, before[2] <= 0.0, False, False], after, before)


@pytest.mark.parametrize("name", BUILT_IN)
def test_citations_resolve(name):
    assert effect(name).cites
    assert set(effect(name).cites) <= set(references())


@pytest.mark.parametrize("name", BUILT_IN)
def test_parameters_are_declared_soundly(name):
    for p in effect(name).parameters:
        assert p.low <= p.default <= p.high
        assert p.std > 0.0
        assert p.doc
        assert p.transform != "log" or p.low > 0.0
        assert p.null is None or p.low <= p.null <= p.high


@pytest.mark.parametrize("name", ADDED)
def test_an_added_effect_can_be_absent_and_says_how_to_show_it(name):
    one = effect(name)
    assert any(p.null is not None for p in one.parameters)
    assert any(p.null is not None and p.null != p.default for p in one.parameters)
    assert one.experiment
    assert one.channels
    assert set(one.confounded) <= set(BUILT_IN) - {name}


def test_all_built_in_effects_work_together_in_their_order():
    plan = compose([effect(name) for name in BUILT_IN])
    assert len(plan.parameters) == sum(len(effect(name).parameters) for name in BUILT_IN)


def test_effects_added_in_any_order_stand_in_the_same():
    from vegrip.model import paper_model

    added = ("saturation", "sensor_lag", "permanent_set", "temperature_shift", "poroelastic_drainage")
    models = [paper_model(0.008), paper_model(0.008)]
    for first, second in zip(added, reversed(added), strict=True):
        models = [models[0].with_effect(effect(first)), models[1].with_effect(effect(second))]
    assert [e.name for e in models[0].effects] == [e.name for e in models[1].effects]


def test_what_lasts_from_trial_to_trial_is_wear_set_drift_and_where_a_play_stands() -> None:
    """And a running maximum follows by itself; every other state recovers and is estimated."""
    states = [s for name in BUILT_IN for s in effect(name).states]
    assert {s.name for s in states if s.lasting} == {"x_p", "delta_max", "d_c", "x_max", "x_h", "b_F"}
    extreme = {"delta_max", "x_max", "x_h", "sticking", "joined", "largest_force"}
    assert {s.name for s in states if s.extreme} == extreme


PACKAGE = Path(vegrip.__file__).parent
OWN = {
    "effects": "the effects",
    "virtual": "the simulators have physics and names of their own",
    "model/model.py": "the paper's model, which is a list of effects",
    "identification/samples": "a sample recording, in which an effect is hidden",
}
"""Files and folders that are about certain effects."""

OTHER_WORDS = {
    ("model/writer.py", "adhesion"): "a quantity of the recursion",
    ("connect/guess.py", "rolling"): "a rolling counter of frames",
    ("identification/recording/import_csv.py", "relaxation"): "what is measured of a material",
}
"""Texts that mean something else."""


def named_effects() -> Iterator[tuple[str, int, str]]:
    """Yield file, line and text of every text in generic code that is the name of an effect."""
    for path in sorted(PACKAGE.rglob("*.py")):
        file = path.relative_to(PACKAGE).as_posix()
        if any(file == own or file.startswith(f"{own}/") for own in OWN):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            named = isinstance(node, ast.Constant) and node.value in BUILT_IN
            if named and (file, node.value) not in OTHER_WORDS:
                yield file, node.lineno, str(node.value)


def test_generic_code_names_no_effect() -> None:
    assert list(named_effects()) == []


@pytest.mark.parametrize("name", BUILT_IN)
def test_what_an_effect_says_of_itself_is_about_itself(name: str) -> None:
    one = effect(name)
    symbols = {p.symbol for p in one.parameters}
    amounts = {p.symbol for p in one.parameters if p.null is not None}
    assert {symbol for symbol, _ in (*one.min_amounts, *one.min_displacement_noises)} <= amounts
    assert {symbol for symbol, _ in one.trial_shapes} <= symbols - amounts
    assert {symbol for symbol, _ in one.beyond_simpler[1]} <= symbols
    for _, values in one.trial_shapes:
        assert all(value > 0.0 for value in values)
    assert all(size > 0.0 for size in one.trial_sizes)
    one.imitated_by.format(**dict.fromkeys(symbols, 1.0), radius=8e-3)


@pytest.mark.parametrize("name", BUILT_IN)
def test_companions_name_each_other(name: str) -> None:
    for other in effect(name).companions:
        assert name in effect(other).companions


TOGETHER = ("K", "p", "c1", "nu1", "mu")
"""Parameters of the base model that are fitted with those of the effect."""


@pytest.mark.parametrize("name", ADDED)
def test_fit_recovers_the_parameters(name, model_with, rich):
    """From 0.3 prior standard deviations off back to 1 % of one; no noise, all that can be measured."""
    truth = model_with(name)
    declared = [truth.parameters[s][1] for s in (*TOGETHER, *(p.symbol for p in effect(name).parameters))]
    std = np.array([p.std for p in declared])
    best = np.array([coordinate(p, truth.values[p.symbol].value) for p in declared])
    low, high = (np.array([coordinate(p, getattr(p, end)) for p in declared]) for end in ("low", "high"))
    outputs = observed(truth, declared, rich)
    measured = outputs(best)
    start = np.clip(best + 0.3 * std, low, high)
    start = np.where(start == best, best - 0.3 * std, start)
    fit = least_squares(
        lambda u: outputs(u) - measured,
        start,
        bounds=(low, high),
        x_scale=std,
        max_nfev=600,
        xtol=1e-12,
        ftol=1e-15,
    )
    away = {p.symbol: float(d) for p, d in zip(declared, (fit.x - best) / std, strict=True)}
    assert max(map(abs, away.values())) < 0.01, away


def observed(model, declared, motion):
    """Give the function from coordinates to forces, radius, 1/k and friction, scaled to order one."""
    places = [list(model.parameters).index(p.symbol) for p in declared]
    log = np.array([p.transform == "log" for p in declared])
    module, inputs, K = model.compiled(), motion.inputs(), model.values["K"].value

    def outputs(u):
        values, out = model.vector, np.empty((motion.t.size, 7))
        values[places] = np.where(log, np.exp(np.where(log, u, 0.0)), u)
        module.run(values, model.initial_states, motion.t, inputs, out)
        out[:, 5] = 1.0 / out[:, 5]
        return (out[::4, 2:] / np.array([K, K, model.tip_radius, 1.0, 1.0])).ravel()

    return outputs


FELT = [name for name in BUILT_IN if name not in BASE and "normal_force" in effect(name).channels]
KINDS = {
    (*sorted({hook.stage for hook in effect(name).hooks}), bool(effect(name).states)): name
    for name in reversed(FELT)
}
NOISE = SensorNoise()


def of_its_kind(name):
    """One of each kind that acts at the same stages; an estimator takes a second to compile."""
    return name if name in KINDS.values() else pytest.param(name, marks=pytest.mark.long)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*map(of_its_kind, FELT)])
def test_the_estimator_is_consistent_with_the_effect_in_its_model(name, model_with, smooth):
    """Innovations as large as stated over the last 3 s, nothing refused, and the stiffness found to 2 %.

    The stiffness is known to 10 % beforehand, as of a fingertip that has been identified. With 50 % the first
    touch leaves the filter of the power-law branches too sure (nu1 17 standard deviations off, NIS 1.05).
    """
    truth, motion = model_with(name), smooth(2e-3, 6.0)
    truth = truth.with_value("K", truth.values["K"].value, std=0.1)
    estimator = ContactEstimator(truth, NOISE)
    nis = followed(estimator, truth, motion)
    assert (
        0.75 < np.mean(nis) < 1.2
    )  # the motion noise is generous: 0.9 without any effect, 0.79 with inertia
    K = estimator.value("K")
    assert abs(np.log(K.value / truth.values["K"].value)) < 0.02
    assert K.std < 0.02
    assert estimator.health().rejected <= 5, "inertia jumps where the motion begins within a sample"


def followed(estimator, truth, motion):
    """The last 1500 normalised innovations squared of a noisy record of ``truth``."""
    nis, rng = [], np.random.default_rng(11)
    force = motion.through(truth).sensed_force + NOISE.normal_force * rng.standard_normal(motion.t.size)
    displacement = motion.displacement + NOISE.displacement * rng.standard_normal(motion.t.size)
    direction = motion.tangential_direction
    for i, t in enumerate(motion.t):
        state = FingertipState(
            int(t * 1e9) + 1,
            "index",
            i,
            normal_force=force[i],
            displacement=displacement[i],
            tangential_force_x=motion.tangential_force[i] * np.cos(direction[i]),
            tangential_force_y=motion.tangential_force[i] * np.sin(direction[i]),
            torque_z=motion.torque[i],
            slip_speed=motion.slip_speed[i],
            temperature=motion.temperature[i],
        )
        estimator.update(state)
        if i >= motion.t.size - 1500:
            nis.append(estimator.health().nis)
    return nis
