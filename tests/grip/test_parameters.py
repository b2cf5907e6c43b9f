"""What of a finger's settings follows from others, and what a file may not set."""

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from typing import Any

import pytest

from vegrip.config import build, declaration
from vegrip.errors import ConfigError
from vegrip.estimator import EstimatorSettings
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.layout import RULES, _rules
from vegrip.grip.node import GraspForce
from vegrip.grip.parameters import GraspParameters, TipParameters, estimator_factory, models_of
from vegrip.grip.policies.baselines import ConeSettings, ConstantSettings, ElasticSettings
from vegrip.grip.safety import WatchdogSettings
from vegrip.grip.safety.drive import DriveLimits
from vegrip.grip.settings import ControlSettings, check_settings
from vegrip.model import paper_model
from vegrip.runtime.lifecycle import rows, with_value

NUMBERS = {
    GraspParameters: """
        report_period                 0.02    0      10      s
        grip.wanted_margin            0.15    0      0.9     1
        grip.drive_lag                0       0      0.2     s
        friction.coefficient          0       0      20      1
        friction.coefficient_std      0       0      2       1
        friction.load_exponent        0.15    -0.5   0.9     1
        friction.load_exponent_std    0.12    0      1       1
        friction.slip_threshold       0       0      10      m/s
        friction.slip_delay           0       0      10      s
        limits.min_force              0.3     0      1000    N
        limits.max_force              15      0      1000    N
        limits.raise_rate             80      0      100000  N/s
        limits.lifetime               0.1     0.001  10      s
        fail_safe.force               5       0      1000    N
        watchdog.time_out             0.05    0.001  10      s
        watchdog.frozen_after         0.25    0.01   3600    s
        watchdog.force_frozen_after   2       0.01   3600    s
        watchdog.stuck_travel         0.0003  1e-6   1       m
        tip.radius                    0.009   1e-9   1       m
        tip.modulus                   3e5     1      1e12    Pa
        noise.normal_force            0.01    1e-18  1e6     N
        noise.displacement            5e-6    1e-18  1       m
        noise.tangential_force        0.01    0      1e6     N
        noise.torque_z                1e-4    0      1e6     N_m
        noise.contact_radius          5e-5    1e-18  1       m
        noise.temperature             0.1     0      100     degC
        sensors.tangential_gain       0.92    0.5    2       1
        sensors.tangential_gain_std   0.1     0      1       1
        estimator.confidence          0.95    0.5    0.9999  1
        estimator.hold_stiffness      1000    0      1e12    N/m
        estimator.agility             3       0.001  1e4     1/s
        estimator.learning_rest       20      0      1e6     s
    """,
    ConstantSettings: """
        force                         5       0      1000    N
    """,
    ConeSettings: """
        friction                      0.8     0.01   10      1
        safety                        0.5     0      100     1
    """,
    ElasticSettings: """
        friction                      0.8     0.01   10      1
        safety                        0.1     0      10      1
        radius                        0.0034  1e-9   1       m
    """,
    DriveLimits: """
        resolution                    0       0      1000    N
        rate                          0       0      1e5     Hz
        delay                         0       0      10      s
        minimum                       0       0      1000    N
        maximum                       inf     0      inf     N
        hysteresis                    0       0      1000    N
    """,
}
"""Name, default, least and largest value, unit: what is promised of every number that a file may set."""
CONSTANTS = """
    health_period                 0.2     0      3600      s
    learned_period                1       0      3600      s
    grip.probability              0.95    1e-6   0.999999  1
    grip.known_probability        0.76    1e-6   0.999999  1
    grip.dead_band                0.04    0      0.9       1
    grip.release_time             0.3     0.001  3600      s
    grip.settle_time              0.1     0      3600      s
    grip.usual_time               2.5     0      3600      s
    grip.proven_time              20      0.001  3600      s
    grip.burst_rate               20      0      10000     1/s
    grip.slip_growth              8       -inf   inf       1/s
    grip.slide_growth             40      -inf   inf       1/s
    friction.own_spread           0.08    0      2         1
    friction.sliding_speed        0.001   0      10        m/s
    limits.lower_rate             8       0      100000    N/s
    fail_safe.hold_time           0.25    0      3600      s
    fail_safe.ramp_rate           10      0      100000    N/s
    watchdog.frozen_chance        1e-7    0      1         1
    watchdog.doubt_after          0.05    0      3600      s
    watchdog.recover_after        5       0      1000000   states
"""
"""The same of every number of the grip that only Python sets."""
RANGES = {
    "normal_force": (-5.0, 60.0), "tangential_force_x": (-60.0, 60.0), "tangential_force_y": (-60.0, 60.0),
    "torque_z": (-2.0, 2.0), "displacement": (-0.05, 0.02), "temperature": (-40.0, 150.0),
    "slip": (0.0, 1.0), "slip_speed": (-10.0, 10.0), "contact_radius": (0.0, 0.05),
}  # fmt: skip
"""What is believed of a channel where nothing else is said."""


def promised(group: type[Any] | None) -> Iterator[tuple[str, float, float, float, str]]:
    for line in (NUMBERS[group] if group is not None else CONSTANTS).strip().splitlines():
        name, default, least, largest, unit = line.split()
        yield name, float(default), float(least), float(largest), unit.replace("_", " ")


def is_out_of_bounds(group: object, name: str, value: float) -> bool:
    """Whether a value is refused for itself; it may still not go with the others."""
    try:
        with_value(group, name, value, running=False, where="hand.toml")
    except ConfigError as refused:
        return "it must lie in" in str(refused)
    return False


@pytest.mark.parametrize("group", NUMBERS)
def test_every_number_that_a_file_may_set_has_its_default_and_unit(group: type[Any]) -> None:
    found = {
        name: (value, declared.unit) for name, value, declared in rows(group()) if type(value) in (int, float)
    }
    assert found == {name: (default, unit) for name, default, _, _, unit in promised(group)}


@pytest.mark.parametrize("group", NUMBERS)
def test_a_number_may_reach_its_bounds_and_no_float_beyond_them(group: type[Any]) -> None:
    for name, _, least, largest, _ in promised(group):
        refused = [
            is_out_of_bounds(group(), name, value)
            for value in (math.nextafter(least, -math.inf), least, largest, math.nextafter(largest, math.inf))
        ]
        assert refused == [True, False, False, largest < math.inf], name


def test_what_only_python_sets_has_its_default_and_unit_and_is_refused_beyond_its_bounds() -> None:
    settings = ControlSettings()
    for name, default, least, largest, unit in promised(None):
        *section, key = name.split(".")
        group: Any = getattr(settings, section[0]) if section else settings
        kind = type(getattr(group, key))
        assert (getattr(group, key), declaration(group, key).unit) == (default, unit), name
        below, above = math.nextafter(least, -math.inf), math.nextafter(largest, math.inf)
        for value in (
            (below, least, largest, above) if kind is float else (least - 1, least, largest, largest + 1)
        ):
            changed = replace(group, **{key: kind(value)})
            given = replace(settings, **{section[0]: changed}) if section else changed
            if least <= value <= largest:
                check_settings(given, ("index",))
            else:
                with pytest.raises(ConfigError, match=f"'{key}' is .*; it must lie in"):
                    check_settings(given, ("index",))


def test_a_channel_is_believed_within_its_range_and_a_range_has_two_different_ends() -> None:
    ranges = WatchdogSettings().ranges
    assert asdict(ranges) == RANGES
    for name in RANGES:
        for wrong in ((), (1.0,), (1.0, 2.0, 3.0), (1.0, 1.0), (2.0, 1.0), (1.0, math.nan)):
            with pytest.raises(ConfigError, match=f"ranges: '{name}' is .*must be \\[least, largest\\]"):
                replace(ranges, **{name: wrong})
        assert getattr(replace(ranges, **{name: (0.5, 1.5)}), name) == (0.5, 1.5)


IN_NANOSECONDS = ("time_out", "frozen_after", "force_frozen_after", "doubt_after")
ELSEWHERE = ("probability", "known_probability", "drive_lag", "burst_rate")


@pytest.mark.parametrize("policy", ["margin", "cone"])
def test_the_step_reads_each_number_in_its_place_and_times_of_the_watchdog_in_nanoseconds(
    make_node: Callable[..., GraspForce], policy: str
) -> None:
    settings = ControlSettings(policy=policy)
    memory = make_node(settings=settings).fingers["index"].memory
    for group in (settings.grip, settings.limits, settings.fail_safe, settings.watchdog):
        for name, value in asdict(group).items():
            if isinstance(value, float) and name not in ELSEWHERE:
                place = f"RULE_{'SAFE_FORCE' if name == 'force' else name.upper()}"
                assert memory[place] == value * (1e9 if name in IN_NANOSECONDS else 1.0), name
    assert memory["RULE_QUANTILE"] == pytest.approx(1.6448536269514722)
    assert memory["SETUP_RECOVER_AFTER"] == 5
    assert list(zip(memory.section("LOWEST"), memory.section("HIGHEST"), strict=True)) == [*RANGES.values()]
    assert memory["SETUP_RENEWAL"] == 25_000_000  # a quarter of the life of a command
    cone = {"FORCE": 0.0, "FRICTION": 0.8, "SAFETY": 0.5, "RADIUS": 0.0, "POWER": 0.0, "EXPONENT": 0.0}
    for name, value in cone.items():
        assert memory[f"BASELINE_{name}"] == (value if policy == "cone" else 0.0)


def test_what_is_no_number_begins_so() -> None:
    begins = {name: value for name, value, _ in rows(GraspParameters()) if isinstance(value, (bool, str))}
    assert begins == {
        "policy": "margin", "thumb": "thumb", "friction.learning": False,
        "friction.object": "", "tip.model": "", "estimator.hold": "position",
        "suspects": True, "learned": "",
    }  # fmt: skip


def estimator_of(table: dict[str, object]) -> EstimatorSettings:
    parameters = build(GraspParameters, table, "hand.toml")
    return estimator_factory(parameters, ("index",), "hand.toml")("index").settings


@pytest.mark.parametrize(
    ("time_out", "gap", "memory"), [(0.05, 0.25, 2.0), (0.03, 0.25, 2.0), (0.1, 0.25, 4.0), (0.5, 0.5, 20.0)]
)
def test_an_estimate_at_a_low_rate_bears_longer_gaps_and_is_judged_by_as_many_samples(
    time_out: float, gap: float, memory: float
) -> None:
    settings = estimator_of({"watchdog": {"time_out": time_out}})
    assert (settings.longest_gap, settings.health_time) == (gap, pytest.approx(memory))


def test_a_tip_has_the_friction_of_its_model_where_none_is_given_and_that_of_the_grasp_goes_before() -> None:
    mu = [
        model.values["mu"]
        for tip in (TipParameters(), TipParameters(friction=0.5), TipParameters(friction_spread=0.2))
        for model in models_of(GraspParameters(tip=tip), ("index",), "hand.toml")
    ]
    known = paper_model(9e-3).values["mu"]
    assert [(one.value, one.std) for one in mu] == [
        (known.value, known.std),
        (0.5, known.std),
        (known.value, 0.2),
    ]
    for coefficient, believed in ((0.0, 0.5), (0.4, 0.4)):
        friction = FrictionSettings(coefficient=coefficient)
        made = estimator_factory(
            GraspParameters(tip=TipParameters(friction=0.5), friction=friction), ("index",), "hand.toml"
        )
        assert made("index").settings.friction.coefficient == believed


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"limits": {"lower_rate": 8.0}}, "lower_rate"),
        ({"fail_safe": {"hold_time": 0.25}}, "hold_time"),
        ({"tip": {"friction": 0.5}}, "friction"),
        ({"tips": {"index": {"friction": 0.5}}}, "friction"),
        ({"estimator": {"horizon": 1.0}}, "horizon"),
    ],
)
def test_a_file_that_sets_a_constant_is_refused_in_one_sentence(table: dict[str, object], key: str) -> None:
    with pytest.raises(ConfigError, match=f"'{key}' is a constant and no parameter; leave it out$"):
        estimator_of(table)


def test_no_two_numbers_of_a_grip_have_one_place_in_its_memory() -> None:
    assert len([*_rules()]) == len(RULES)
