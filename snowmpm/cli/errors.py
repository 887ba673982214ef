"""What a command does when something goes wrong: one or two lines on stderr and an exit code."""

import functools
import inspect
import sys
import traceback
from typing import Annotated

import typer

from snowmpm.errors import InputError, SimulationError

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]


def guarded(command):
    """The command with an option `--debug` and with errors turned into messages and exit codes.

    InputError -> 2, SimulationError -> 1, interruption -> 130, anything else -> 1 and a hint at `--debug`.
    """

    @functools.wraps(command)
    def call(*args, debug, **options):
        try:
            return command(*args, **options)
        except typer.Exit:
            raise
        except InputError as error:
            code, message = BAD_INPUT, str(error)
        except SimulationError as error:
            code, message = FAILED, str(error)
        except KeyboardInterrupt as error:
            code, message = INTERRUPTED, str(error) or "interrupted"
        except MemoryError:
            code, message = FAILED, "out of memory: a coarser dx or fewer particles_per_cell needs less"
        except OSError as error:
            code, message = FAILED, f"{error.filename or 'system'}: {error.strerror or error}"
        except Exception as error:
            text = " ".join(str(error).split())[:200]
            code, message = FAILED, f"unexpected {type(error).__name__}: {text}\nThis is a fault of the program; "
            message += "with --debug it shows where."
        if debug:
            traceback.print_exc()
        print(f"error: {message}" if code != INTERRUPTED else message, file=sys.stderr)
        raise typer.Exit(code)

    signature = inspect.signature(command)
    option = inspect.Parameter("debug", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Debug)
    call.__signature__ = signature.replace(parameters=[*signature.parameters.values(), option])
    return call
