"""REPORT.md of an export: what was measured, with what, and what was not."""

from vegrip.c99.kinds import DOUBLE, FLOAT
from vegrip.export.measure import Measured, Run, Size
from vegrip.export.precision import PRECISIONS
from vegrip.export.request import Request
from vegrip.export.texts import Texts, filled

WORDS = {
    "update": "update", "slip_margin": "slip margin", "least_force": "least force", "frame": "frame",
    "tick": "tick",
}  # fmt: skip
SEQUENCE = {
    "estimator": "presses, slips, lost and wrong samples, a late one",
    "finger": "frames of presses, slips, lost and wrong samples, broken frames, silence and ticks",
}
COMPARED = {"estimator": "every output", "finger": "every command"}
RAMP = "The largest difference is that of a fail-safe ramp that begins one command earlier or later.\n\n"


def report(request: Request, texts: Texts, measured: Measured) -> str:
    """Return the page."""
    precision, is_finger = PRECISIONS[request.precision], request.entry == "finger"
    core, run = precision.processor["Core"], measured.cortex_run
    sizes = (("this machine", measured.host), (core, measured.cortex))
    counted = run is not None and run.instructions
    known = {
        **precision.known,
        "name": f"{request.prefix}_{request.entry}", "prefix": request.prefix, "entry": request.entry,
        "effects": ", ".join(effect.name for effect in request.model.effects), "hash": texts.text_hash,
        "kind": precision.words["precision"].lower(), "count": str(len(texts.program.functions)),
        "ram": str(texts.ram),
        "sizes": "".join(_size(name, size) for name, size in sizes if size is not None),
        "sequence": SEQUENCE[request.entry], "compared": COMPARED[request.entry],
        "whole": " and, at the end, the whole memory" if precision.reals == DOUBLE else "",
        "largest": precision.words["finger_difference" if is_finger else "difference"],
        "runs": "".join(_run(one) for one in (measured.host_run, run) if one is not None),
        "ramp": RAMP if is_finger and precision.reals == FLOAT else "",
        "instructions": _instructions(measured, run) if run is not None and counted else "",
        "missing": "".join(f"* {one} was not there when this was written\n" for one in measured.missing),
    }  # fmt: skip
    return filled("REPORT.md", known)


def _size(target: str, size: Size) -> str:
    depths = ", ".join(f"{WORDS[name]} {depth}" for name, depth in size.stack.items())
    stack = depths or "not reported by this compiler"
    return f"| {target} | {size.compiler} | {size.flash} | {size.ram} | {stack} |\n"


def _run(run: Run) -> str:
    result = f"PASS {run.frames} frames" if run.passed else "FAIL"
    return f"| {run.machine} | {result} | {run.equal} of {run.numbers} | {run.largest:.3g} |\n"


def _instructions(measured: Measured, run: Run) -> str:
    most = measured.search.most if measured.search is not None else {}
    rows = (
        f"| {WORDS[name]} | {usual} | {recorded} | {most.get(name, '-')} |\n"
        for name, (usual, recorded) in run.instructions.items()
    )
    tried = f"most of {measured.search.inputs} inputs" if measured.search is not None else "most found"
    return filled("REPORT_instructions.md", {"machine": run.machine, "tried": tried, "rows": "".join(rows)})
