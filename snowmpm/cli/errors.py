"""How a command fails: one or two lines on stderr and an exit code."""

import contextlib
import errno
import functools
import inspect
import os
import sys
import traceback
import warnings
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.watch import Form, watched
from snowmpm.errors import InputError, SimulationError, shown_lines
from snowmpm.running.interruption import requests_to_end

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
OF_THE_NAME = (errno.ENAMETOOLONG, errno.ELOOP, errno.EEXIST, errno.ENOTDIR, errno.EISDIR)
"""System errors caused by a name that the user gave: a name too long, a file in place of a folder."""

Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace files that snowmpm did not write, or that were changed since.")
]
PluginFiles = Annotated[
    list[str] | None,
    typer.Option("--plugin", metavar="FILE_OR_MODULE", help="Load laws, events, shapes and so on from a .py file, or"
                 " from a module that is installed; repeatable. What installed packages bring is loaded by itself."),
]
NoPlugins = Annotated[bool, typer.Option("--no-plugins", help="Load no plugins of installed packages.")]
Progress = Annotated[
    Form, typer.Option("--progress", help="auto: a bar on a terminal, elsewhere a line every ten seconds; lines: also"
                       " on a terminal; json: an object a line on stderr, for programs that show a bar.")
]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]


def explained(error):
    """Exit code and message for the exception that ended a command."""
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED, str(error) or "interrupted"
    if isinstance(error, InputError):
        return BAD_INPUT, f"error: {error}"
    if isinstance(error, SimulationError):
        return FAILED, f"error: {error}"
    if isinstance(error, MemoryError):
        return FAILED, "error: out of memory: a coarser dx or fewer particles_per_cell needs less"
    if isinstance(error, OSError) and error.errno in OF_THE_NAME:
        return BAD_INPUT, f"error: {error.filename or 'a file'}: {error.strerror}"
    if isinstance(error, OSError):
        # Errors of files carry a name; those of printing do not
        where = error.filename or ("standard output" if error.errno == errno.ENOSPC else "system")
        return FAILED, f"error: {where}: {error.strerror or error}"
    text = " ".join(str(error).split())[:200]
    return FAILED, f"error: unexpected {type(error).__name__}: {text}\na fault of the program; --debug shows where"


told: set[str] = set()
"""Warnings that the command has shown."""


def warn(message, *_, **__):
    """Replaces `warnings.showwarning` while a command runs: one or two lines on stderr, each once."""
    line = f"warning: {shown_lines(str(message))}"
    if line not in told:
        print(line, file=sys.stderr)
    told.add(line)


def load_plugins(sources, installed=True):
    """Load the plugins of installed packages, and those that the command line names. Raises InputError."""
    from snowmpm import plugins

    if installed:
        plugins.load_installed()
    for source in sources:
        plugins.load(source)


def guarded(command, writes=True, computes=False):
    """The command with an option `--debug` and with errors turned into messages and exit codes; one that writes files
    with an option `--overwrite`, without which it keeps those of the user (`snowmpm.overwriting`), and `--progress`;
    one that computes with an option `--plugin` (`snowmpm.plugins`).

    InputError -> 2, SimulationError -> 1, interruption -> 130, anything else -> 1 and a hint at `--debug`.
    """
    signature = inspect.signature(command)
    own = "overwrite" in signature.parameters

    @functools.wraps(command)
    def call(*args, debug, overwrite=False, plugin=None, no_plugins=False, progress=Form.auto, **options):
        options |= {"overwrite": overwrite} if own else {}
        overwriting.forget_inputs()
        told.clear()
        try:
            with warnings.catch_warnings():
                warnings.showwarning = warn
                warnings.filterwarnings("ignore", category=RuntimeWarning)  # of arithmetic: the results are checked
                with requests_to_end(), watched(bool(options.get("quiet")), form=progress), \
                        overwriting.keeping(overwrite):
                    if computes:
                        load_plugins(plugin or (), installed=not no_plugins)
                    return command(*args, **options)
        except typer.Exit:
            raise
        except BrokenPipeError:
            # The reader of the pipe has closed it; the interpreter must not complain when it flushes
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(DONE) from None
        except (Exception, KeyboardInterrupt) as error:
            if debug:
                traceback.print_exception(error)
            code, message = explained(error)
        # Python ends by SIGINT, whatever the exit code, where Ctrl-C hit while a text was executed; this one was not
        exec("pass")
        with contextlib.suppress(OSError):  # no output is left, but the exit code remains
            print(shown_lines(message), file=sys.stderr, flush=True)
        raise typer.Exit(code)

    options = {**({"overwrite": Overwrite} if writes and not own else {}), **({"progress": Progress} if writes else {}),
               **({"plugin": PluginFiles, "no_plugins": NoPlugins} if computes else {}), "debug": Debug}
    defaults = {"plugin": None, "progress": Form.auto}
    more = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=defaults.get(name, False), annotation=kind)
            for name, kind in options.items()]
    call.__signature__ = signature.replace(parameters=[*signature.parameters.values(), *more])
    return call
