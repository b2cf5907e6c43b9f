"""Help that keeps its units, and errors of usage as one sentence with the remedy."""

import re
from typing import Any

import typer
from rich.markup import escape

from vegrip.errors import suggestion

SINGLE_BREAK = re.compile(r"(?<!\n)\n *(?!\n)")  # inside a paragraph
HELP = {"help_option_names": ["-h", "--help"]}


def literal(app: typer.Typer) -> Any:
    """Return the command of ``app``, its help taken as it stands: ``[m]`` is a unit, no markup."""
    command = typer.main.get_command(app)
    _make_literal(command)
    command.context_settings = {**command.context_settings, **HELP}
    return command


def _make_literal(command: Any) -> None:
    command.help = escape(SINGLE_BREAK.sub(" ", command.help or ""))
    if command.short_help:
        command.short_help = escape(command.short_help)
    for parameter in command.params:
        if getattr(parameter, "help", None):
            parameter.help = escape(parameter.help)
    for sub in getattr(command, "commands", {}).values():
        _make_literal(sub)


def explained(error: typer.TyperException, program: str) -> str:
    """Return the mistake in one sentence, with what to do."""
    context = getattr(error, "ctx", None)
    path = context.command_path if context is not None else program
    sentence = _sentence(error, context)
    return f"{sentence}{'' if sentence.endswith('?') else ';'} see {path} -h"


def _sentence(error: typer.TyperException, context: Any) -> str:
    parameter, kind = getattr(error, "param", None), type(error).__name__
    if kind == "NoSuchOption" and context is not None:
        given = getattr(error, "option_name", "")
        known = [option for each in context.command.params for option in each.opts if option[:2] == "--"]
        return f"there is no option {given}; {suggestion(given, known)}"
    if parameter is None:
        return _plain(error.format_message())
    name = "/".join(parameter.opts) if parameter.param_type_name == "option" else parameter.name.upper()
    meaning = f" ({parameter.help})".replace("\\[", "[").replace(".)", ")") if parameter.help else ""
    if kind == "MissingParameter":
        return f"{name} is missing{meaning}"
    return f"{name} {_given(error)}{_plain(error.message)}{meaning}"


def _given(error: BaseException) -> str:
    errors = getattr(error.__cause__, "errors", None)
    if errors is None:
        return ""
    return f"is {errors()[0].get('input')!r}: it "


def _plain(message: str) -> str:
    message = message.strip().rstrip(".")
    for start in ("Input ", "Value error, "):
        message = message.removeprefix(start)
    message = message.replace("should be", "must be").replace(". Did", "; did")
    return message[:1].lower() + message[1:]
