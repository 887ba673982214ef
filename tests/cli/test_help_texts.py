"""Help of every command: the text as it was written, to the last bracket."""

import inspect
import re

import pytest
import typer.main

from snowmpm.cli.app import app


def tree(command, path=()):
    """(words, command, parent) of all commands."""
    yield path, command
    for name, one in getattr(command, "commands", {}).items():
        yield from tree(one, (*path, name))


COMMANDS = list(tree(typer.main.get_command(app)))


def texts_of(command):
    """What was written of a command and its parameters, before anything is made of it."""
    if command.callback is None:  # of a group without options
        yield command.help or ""
        return
    callback = inspect.unwrap(command.callback)
    yield inspect.getdoc(callback) or ""
    for annotation in callback.__annotations__.values():
        for info in getattr(annotation, "__metadata__", ()):
            yield info.help or ""


@pytest.mark.parametrize("path, command", COMMANDS, ids=[" ".join(path) or "snowmpm" for path, _ in COMMANDS])
def test_brackets_are_printed(path, command, call, monkeypatch):
    monkeypatch.setattr("typer.rich_utils.MAX_WIDTH", 4000)
    help_text = call(*path, "--help").out
    written = [found for text in texts_of(command) for found in re.findall(r"\[[^\]]*\]", text)]
    for bracket in written:
        assert " ".join(bracket.split()) in " ".join(help_text.split()), bracket
    assert "\\[" not in help_text


def test_there_are_brackets():
    """Else the test above tests nothing."""
    written = " ".join(text for _, command in COMMANDS for text in texts_of(command))
    assert {"[picture]", "[reference]", "[m]"} <= set(re.findall(r"\[\w+\]", written))
