"""REPORT.md of an export: what was measured, with what, and what was not."""

from collections.abc import Iterator

from vegrip.c99.kinds import DOUBLE, FLOAT
from vegrip.export.measure import Measured, Run, Size
from vegrip.export.precision import PRECISIONS
from vegrip.export.request import Request
from vegrip.export.texts import Texts

WORDS = {
    "update": "update", "slip_margin": "slip margin", "least_force": "least force", "frame": "frame",
    "tick": "tick",
}  # fmt: skip
SEQUENCE = {
    "estimator": "presses, slips, lost and wrong samples, a late one",
    "finger": "frames of presses, slips, lost and wrong samples, broken frames, silence and ticks",
}
COMPARED = {"estimator": "every output", "finger": "every command"}


def report(request: Request, texts: Texts, measured: Measured) -> str:
    """Return the page."""
    return "\n".join(
        [
            *_what(request, texts),
            *_sizes(request, texts, measured),
            *_runs(request, measured),
            *_instructions(measured),
            *_not_measured(measured),
        ]
    )


def _what(request: Request, texts: Texts) -> Iterator[str]:
    yield f"# {request.prefix}_{request.entry}: what it needs, and whether it agrees"
    yield ""
    yield "Written by `vegrip export c`; `make` runs the self-test with your own compiler."
    yield ""
    yield f"* model: {', '.join(effect.name for effect in request.model.effects)} (`model.toml`)"
    yield f"* SHA-256 of the generated text: `{texts.text_hash}`"
    count, precision = len(texts.program.functions), PRECISIONS[request.precision]
    named = f"{precision.words['precision'].lower()} precision; prefix `{request.prefix}`"
    yield f"* {named}; {count} functions of the {request.entry}"
    yield ""


def _sizes(request: Request, texts: Texts, measured: Measured) -> Iterator[str]:
    yield "## Size"
    yield ""
    yield f"Memory of one finger: {texts.ram} bytes, where you put it."
    yield "Nothing is kept outside it, nothing is allocated."
    yield ""
    processor = PRECISIONS[request.precision].processor
    yield "| for | compiler | flash [bytes] | other RAM [bytes] | stack [bytes] |"
    yield "| --- | --- | --- | --- | --- |"
    for target, size in (("this machine", measured.host), (processor["Core"], measured.cortex)):
        if size is not None:
            yield f"| {target} | {size.compiler} | {size.flash} | {size.ram} | {_stack(size)} |"
    yield ""
    yield f"Compiled with -O2, without fused multiply-add; for the {processor['Core']} {processor['cpu']}."
    yield "Flash is code and tables of the exported file, without the mathematical library. Stack is the"
    yield "deepest way down by `-fstack-usage`; what is called in the mathematical library comes on top."
    yield ""


def _stack(size: Size) -> str:
    return (
        ", ".join(f"{WORDS[name]} {depth}" for name, depth in size.stack.items())
        or "not reported by this compiler"
    )


def _runs(request: Request, measured: Measured) -> Iterator[str]:
    yield "## Agreement with Python"
    yield ""
    yield "The self-test runs a recorded sequence"
    yield f"({SEQUENCE[request.entry]})"
    precision = PRECISIONS[request.precision]
    whole = " and, at the end, the whole memory" if precision.reals == DOUBLE else ""
    yield f"and compares {COMPARED[request.entry]}{whole} with Python's, in double precision."
    yield ""
    difference = precision.words["finger_difference" if request.entry == "finger" else "difference"]
    yield f"| machine | result | numbers equal to the bit | largest {difference} |"
    yield "| --- | --- | --- | --- |"
    for run in (measured.host_run, measured.cortex_run):
        if run is not None:
            yield f"| {run.machine} | {_result(run)} | {run.equal} of {run.numbers} | {run.largest:.3g} |"
    yield ""
    if request.entry == "finger" and precision.reals == FLOAT:
        yield "The largest difference is that of a fail-safe ramp that begins one command earlier or later."
        yield ""


def _instructions(measured: Measured) -> Iterator[str]:
    run = measured.cortex_run
    if run is None or not run.instructions:
        return
    yield "## Instructions of a call"
    yield ""
    yield f"Counted by the emulator ({run.machine}), in steps of 40: over the recorded sequence, and the"
    yield "most that was found by changing its numbers and times (`make worst`). A pause is worked out in"
    yield "steps, so the first call after a silence takes most. Every loop has a bound, but this search is no"
    yield "proof of the worst."
    yield ""
    most = measured.search.most if measured.search is not None else {}
    tried = f"most of {measured.search.inputs} inputs" if measured.search is not None else "most found"
    yield f"| call | on average | at most | {tried} |"
    yield "| --- | --- | --- | --- |"
    for name, (usual, recorded) in run.instructions.items():
        yield f"| {WORDS[name]} | {usual} | {recorded} | {most.get(name, '-')} |"
    yield ""


def _result(run: Run) -> str:
    return f"PASS {run.frames} frames" if run.passed else "FAIL"


def _not_measured(measured: Measured) -> Iterator[str]:
    yield "## Not measured"
    yield ""
    yield "* processor time on your board: count cycles there; an emulator counts instructions, not cycles"
    yield "* the stack that your mathematical library needs"
    for what in measured.missing:
        yield f"* {what} was not there when this was written"
    yield ""
