"""Every command with its arguments and options, from the program's own help."""

from enum import Enum

from snowmpm.cli.reference.markdown import code, plain, table

INTRODUCTION = """# Commands

`snowmpm COMMAND --help` also shows the choices and ranges of options. Exit codes: 0 done, 1 the simulation failed,
2 bad input, 130 interrupted.
"""


def page():
    """All commands as Markdown."""
    import typer
    from typer.core import TyperGroup

    from snowmpm.cli.app import app

    lines = [INTRODUCTION]
    for name, command in typer.main.get_command(app).commands.items():
        group = isinstance(command, TyperGroup)
        for inner, one in (command.commands if group else {"": command}).items():
            lines += _command(f"{name} {inner}".strip(), one)
    return "\n".join(lines)


def _command(name, command):
    arguments = [one for one in command.params if one.param_type_name == "argument"]
    options = [one for one in command.params if one.param_type_name == "option" and not one.hidden]
    shown = " ".join(_shown(one) for one in arguments)
    yield from (f"## {name}", "", f"`snowmpm {name} {shown}".rstrip() + " [OPTIONS]`", "")
    for paragraph in _unmarked(command.help).split("\n\n"):
        yield from (plain(paragraph), "")
    rows = [(code(one.metavar or one.name.upper()), "", _words(one)) for one in arguments]
    rows += [(code(_option(one)), code(_default(one)), _words(one)) for one in options if one.name != "help"]
    yield from table(("argument or option", "default", "what it is"), rows)


def _words(one):
    return plain(_unmarked(one.help))


def _unmarked(words):
    """Help without the marks that keep words from being markup of the terminal."""
    return (words or "").replace("\b", "").replace("\\[", "[")


def _option(one):
    metavar = (one.metavar or "").replace("\\|", "|")
    return " ".join([", ".join([*one.opts, *one.secondary_opts]), metavar]).strip()


def _shown(argument):
    name = (argument.metavar or argument.name.upper()).strip("[]")
    return f"{name}{'...' if argument.nargs < 0 else ''}" if argument.required else f"[{name}]"


def _default(option):
    value = option.default
    value = value.value if isinstance(value, Enum) else value
    return value if isinstance(value, str | int | float) and not isinstance(value, bool) else ""
