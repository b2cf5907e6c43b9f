"""Tries a composed model on a few contacts, hook by hook, and names the effect that fails."""

import math
from collections.abc import Sequence
from typing import Any

from vegrip.effects.contract import FACTORS, GEOMETRY, STAGES, STARTS, Effect
from vegrip.errors import ModelError
from vegrip.model.composer import Call, Plan
from vegrip.types import Floats

PROBED_DEPTHS = (-0.5, 0.0, 1e-6, 0.3, 1.0, 2.0)  # in reference depths
PROBED_STEPS_S = (0.0, 1e-3, 1.0)  # [s]


def probe(
    effects: Sequence[Effect],
    plan: Plan,
    values: Floats,
    reference_depth: float,
) -> None:
    """Run every hook once at each depth and step.

    Raises:
        ModelError: a hook fails, returns the wrong number of values, or something not finite.

    """
    functions = _functions(plan)
    constants = dict(zip([*plan.parameters, *GEOMETRY], map(float, values), strict=True))
    states = {s.name: s.initial for e in effects for s in e.states}
    for depth in PROBED_DEPTHS:
        for dt in PROBED_STEPS_S:
            scope: dict[str, float] = {**constants, **states, **FACTORS, "dt": dt}
            scope |= {"delta": depth * reference_depth, "speed": 0.1 * reference_depth, "elastic_before": 0.0}
            scope |= {"temperature": constants["reference_temperature"] + 1.0, "slip_speed": 0.0}
            scope |= {"tangential_force": 0.0, "tangential_force_x": 0.0, "tangential_force_y": 0.0}
            scope |= {"torque": 0.0, "stiffness": 1.0, "elastic_exponent": 1.5}
            _walk(plan, functions, scope)
            states = {name: scope[name] for name in states}


def _functions(plan: Plan) -> dict[str, Any]:
    scope: dict[str, Any] = {"math": math}
    for text in plan.texts.values():
        exec(compile(text, "<effect>", "exec"), scope)  # noqa: S102 - the user's own model, as on import
    return scope


def _walk(plan: Plan, functions: dict[str, Any], scope: dict[str, float]) -> None:
    for stage, quantity in STAGES.items():
        if quantity in STARTS:
            scope[quantity] = scope[STARTS[quantity]]
        for call in plan.calls[stage]:
            scope |= _checked(call, functions[call.function], scope)
        scope["force"] = max(scope.get("force", 0.0), 0.0)


def _checked(call: Call, function: Any, scope: dict[str, float]) -> dict[str, float]:
    arguments = {name: scope[name] for name in call.takes}
    at = ", ".join(f"{name} = {value:g}" for name, value in arguments.items())
    try:
        answer = function(**arguments)
    except Exception as error:
        raise ModelError(
            f"the effect {call.effect} fails at {call.stage} ({error}) with {at}; guard it"
        ) from error
    given = answer if isinstance(answer, tuple) else (answer,)
    if len(given) != len(call.results):
        raise ModelError(
            f"the effect {call.effect} returns {len(given)} values at {call.stage}; "
            f"it must return {', '.join(call.results)}"
        )
    for name, value in zip(call.results, given, strict=True):
        if not math.isfinite(value):
            raise ModelError(
                f"the effect {call.effect} gives {name} = {value} at {call.stage} with {at}; guard it"
            )
    return dict(zip(call.results, given, strict=True))
