"""Help texts in which square brackets are square brackets: typer hands all texts to rich, which takes [...] as markup
and prints nothing of it."""

from rich.markup import escape
from typer.core import TyperCommand, TyperGroup


class PlainCommand(TyperCommand):
    """A command whose texts have no markup."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        _escape(self)


class PlainGroup(TyperGroup):
    """A group of commands whose texts have no markup."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        _escape(self)


def _escape(command):
    """Escape the texts of a command and of its parameters, which are its own; without rich they are printed as they
    are."""
    if command.rich_markup_mode != "rich":
        return
    for part, name in ((command, "help"), (command, "short_help"), (command, "epilog"),
                       *((parameter, "help") for parameter in command.params)):
        if text := getattr(part, name, None):
            setattr(part, name, escape(text))
