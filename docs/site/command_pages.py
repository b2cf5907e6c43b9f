"""The pages of the command line, written from the commands themselves: what ``vegrip COMMAND -h`` says."""

import re
from collections.abc import Iterator
from typing import Any

from typer.main import get_command

from vegrip.cli import GROUPS, load


def pages() -> Iterator[tuple[str, str]]:
    """Yield (file name, Markdown) for each group of commands."""
    for heading, commands in GROUPS.items():
        text = [f"# {heading}: commands", "", "| command | what it does |", "|---|---|"]
        text += [f"| [`vegrip {name}`](#vegrip-{name}) | {about} |" for name, about in commands.items()]
        for name in commands:
            command = get_command(load(name))
            text += ["", *described(command, f"vegrip {name}", level=2)]
        yield f"{_slug(heading)}.md", "\n".join(text) + "\n"


def options() -> Iterator[tuple[str, str, str, str]]:
    """Yield group of commands, command, option and what it is for, of each option."""
    for heading, commands in GROUPS.items():
        for name in commands:
            for full, command in _leaves(get_command(load(name)), f"vegrip {name}"):
                for one in command.params:
                    if one.param_type_name == "option" and not one.hidden:
                        yield heading, full, one.opts[0], _cell(str(one.help or ""))


def _leaves(command: Any, name: str) -> Iterator[tuple[str, Any]]:
    children = getattr(command, "commands", {})
    for child in children.values():
        yield from _leaves(child, f"{name} {child.name}")
    if not children:
        yield name, command


def described(command: Any, name: str, level: int) -> Iterator[str]:
    """Yield the lines of one command, and of the commands below it."""
    yield f"{'#' * level} {name}"
    yield ""
    yield from _paragraphs(command.help or "")
    children = getattr(command, "commands", {})
    for child in children.values():
        yield ""
        yield from described(child, f"{name} {child.name}", level + 1)
    if children:
        return
    parameters = [parameter for parameter in command.params if not parameter.hidden]
    arguments = [parameter for parameter in parameters if parameter.param_type_name == "argument"]
    usage = [name, *(_in_usage(argument) for argument in arguments), "[OPTIONS]"]
    yield f"```text\n{' '.join(usage)}\n```\n"
    context = command.context_class(command, info_name=name)
    yield "| name | type | meaning |"
    yield "|---|---|---|"
    for parameter in parameters:
        yield _row(parameter, context)


def _in_usage(argument: Any) -> str:
    word = argument.name.upper() + ("..." if argument.nargs != 1 else "")
    return word if argument.required else f"[{word}]"


def _row(parameter: Any, context: Any) -> str:
    is_argument = parameter.param_type_name == "argument"
    names = [parameter.name.upper()] if is_argument else [*parameter.opts, *parameter.secondary_opts]
    about = str(parameter.help or "")
    if parameter.default not in (None, False, (), [], "") and not callable(parameter.default):
        about += f" Default: {parameter.default}."
    cells = (
        ", ".join(f"`{name}`" for name in names),
        _cell(str(parameter.display_type(context))),
        _cell(about),
    )
    return f"| {' | '.join(cells)} |"


def _paragraphs(text: str) -> Iterator[str]:
    for paragraph in re.split(r"\n\s*\n", text.replace("\b", "").replace("\f", "")):
        words = " ".join(paragraph.split())
        example, colon, command = words.partition("Example: ")
        if colon:
            if example:
                yield f"{_prose(example)}\n"
            yield "```sh\n" + command.replace(" && ", "\n") + "\n```\n"
        elif words:
            yield f"{_prose(words)}\n"


def _prose(text: str) -> str:
    return text.strip().replace("[", "\\[").replace("*", "\\*").replace("<", "&lt;")


def _cell(text: str) -> str:
    return _prose(" ".join(text.split())).replace("|", "\\|")


def _slug(heading: str) -> str:
    return heading.lower().replace(" ", "-")
