"""The exported estimator: samples in, estimates out."""

from dataclasses import replace

import numpy as np

from vegrip.c99 import LONGS, literals
from vegrip.estimator import ContactEstimator
from vegrip.estimator.compiled import clock_text_of
from vegrip.estimator.estimator import quantile
from vegrip.estimator.kernels_c import ENTRIES
from vegrip.estimator.layout import FRICTION, Layout
from vegrip.estimator.memory import CHANNELS
from vegrip.estimator.origins import Origins
from vegrip.export.precision import MARGIN, PRECISIONS, Request, Unit
from vegrip.export.vectors import FLAGS, OUTPUTS, Vectors, record


def unit(request: Request) -> Unit:
    """Return what is exported."""
    model, p, reals = request.model, request.prefix, PRECISIONS[request.precision].reals
    vectors, settings = record(request), request.settings
    blank = ContactEstimator(model, request.noise, replace(settings, late=0))
    layout = blank.layout
    entries = {name: ENTRIES[name] for name in ("assimilate", "margin_of", "least_force")}
    measured = (f"    e->f.named.state.{name} = sample->{name};" for name in CHANNELS)
    words = {
        "recovery": str(settings.recovery), "horizon": f"{settings.horizon:g}",
        "risk": f"{1.0 - settings.confidence:.3g}",
        "quantile": literals.real(quantile(settings.confidence), reals), "margin": literals.real(MARGIN),
        "temperature": f"{model.reference_temperature:g}", "measured": "\n".join(measured),
        "believed": "true", "command": "",
        "row": "frame", "ROW": "FRAME", "worst_sources": f"{p}_worst.c {p}_vectors.c {p}_estimator.c",
        **_parameters(request, layout), **_rows(vectors),
    }  # fmt: skip
    text = clock_text_of(model, layout, ellipse=settings.surface == "ellipse")
    entries |= {"informed_age": (LONGS,)}
    return Unit(text, Origins(model.effects), entries, blank.named, vectors.reals, words)


def _parameters(request: Request, layout: Layout) -> dict[str, str]:
    model, p, reals = request.model, request.prefix, PRECISIONS[request.precision].reals
    variances, stds, lines = [], [], []
    for place, (symbol, (effect, declared)) in enumerate(model.parameters.items()):
        value = model.values[symbol]
        variances.append(str(_variance_of(layout, place)))
        stds.append(literals.real(0.0 if np.isnan(value.std) else value.std, reals))
        learned = "learned" if place in layout.learned or place == layout.mu else "as told"
        doc = f"{effect}: {declared.doc}".replace("*/", "* /")
        lines.append(f"    {p.upper()}_PARAMETER_{symbol}, /* [{declared.unit}] {doc}; {learned} */")
    return {
        "parameters": "\n".join(lines),
        "variance_of": ", ".join(variances),
        "std_of": ", ".join(stds),
    }


def _variance_of(layout: Layout, place: int) -> int:
    """Return where the variance of a parameter lies in the memory, or -1."""
    if place == layout.mu:
        return layout.places()["FRICTION"][0] + FRICTION.index("VAR")
    if place in layout.learned:
        j = layout.learned_from + layout.learned.index(place)
        return layout.places()["P"][0] + j * layout.n + j
    return -1


def _rows(vectors: Vectors) -> dict[str, str]:
    rows = []
    for frame in vectors.frames:
        inputs = ", ".join(literals.hexadecimal(one) for one in frame.inputs)
        outputs = ", ".join(literals.hexadecimal(one) for one in frame.outputs)
        rows.append(f"    {{{frame.stamp}LL, {{{inputs}}},\n     {{{outputs}}}, {frame.flags}U}},")
    return {
        "frames": str(len(vectors.frames)),
        "outputs": str(len(OUTPUTS)),
        "output_names": ", ".join(OUTPUTS),
        "flag_names": ", ".join(FLAGS),
        "rows": "\n".join(rows),
    }
