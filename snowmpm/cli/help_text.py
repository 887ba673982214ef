"""Help texts in which square brackets are square brackets: typer hands all texts to rich, which takes [...] as markup
and prints nothing of it. And what is wrong with the words of a command, in one line like every other error."""

import sys
from dataclasses import replace

import typer
from rich.markup import escape
from typer.core import TyperCommand, TyperGroup

from snowmpm.errors import shown_lines

UsageError = typer.BadParameter.__mro__[1]
"""Of the click that typer brings with it, or stands on."""


class PlainCommand(TyperCommand):
    """A command whose texts have no markup."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        _escape(self)


class PlainGroup(TyperGroup):
    """A group of commands whose texts have no markup, and whose errors of usage are a line."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        _escape(self)

    def resolve_command(self, ctx, args):
        """A command of a plugin is known once the plugins that the command line names, and those of installed packages,
        are loaded."""
        if args and self.get_command(ctx, args[0]) is None:
            add_commands_of_plugins(self, args)
        return super().resolve_command(ctx, args)

    def main(self, *args, standalone_mode=True, **options):
        try:
            ended = super().main(*args, standalone_mode=False, **options)
        except UsageError as error:
            if not standalone_mode:
                raise
            if type(error).__name__ != "NoArgsIsHelpError":  # which has shown the help
                where = f" ({error.ctx.command_path} --help)" if error.ctx else ""
                said = error.format_message().replace("Value error, ", "").rstrip(".")
                print(shown_lines(f"error: {said}{where}"), file=sys.stderr)
            sys.exit(error.exit_code)
        except typer.Abort:  # Ctrl-C before a command has begun
            if not standalone_mode:
                raise
            print("interrupted", file=sys.stderr)
            sys.exit(130)
        if standalone_mode:
            sys.exit(ended if isinstance(ended, int) else 0)
        return ended


def add_commands_of_plugins(group, args):
    """Load plugins and add their commands to a group."""
    from snowmpm.cli.errors import load_plugins
    from snowmpm.errors import InputError
    from snowmpm.registry import COMMANDS

    named = [args[i + 1] for i, word in enumerate(args[:-1]) if word == "--plugin"]
    named += [word.partition("=")[2] for word in args if word.startswith("--plugin=")]
    try:
        load_plugins(named, installed="--no-plugins" not in args)
    except InputError as error:
        raise UsageError(str(error)) from None
    app = typer.Typer(cls=PlainGroup)
    for command in COMMANDS.values():
        if command.name not in group.commands:
            replace(command, computes=True).add_to(app)  # --plugin names it
    if app.registered_commands:
        app.callback()(lambda: None)
        group.commands |= typer.main.get_command(app).commands


def _escape(command):
    """Escape the texts of a command and of its parameters, which are its own; without rich they are printed as they
    are."""
    if command.rich_markup_mode != "rich":
        return
    for part, name in ((command, "help"), (command, "short_help"), (command, "epilog"),
                       *((parameter, "help") for parameter in command.params)):
        if text := getattr(part, name, None):
            setattr(part, name, escape(text))
