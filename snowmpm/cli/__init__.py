"""The command line: `snowmpm COMMAND ...`, one file a command.

Modules here import nothing heavy at the top: a command that needs Taichi, VTK or Matplotlib imports them when it runs,
so that `--help` and a misspelt option answer at once.
"""


def main():
    """Entry point of the console script and of `python -m snowmpm`."""
    import gc
    import os
    import sys

    # Taichi's import banner would precede every message.
    os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")
    # So would its warning about a replaced standard output; kernels print nothing
    os.environ.setdefault("TI_ENABLE_PYBUF", "0")
    # Threads of NumPy's BLAS wait at work, a fifth of the time of a short command; kernels are what takes cores here
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(50_000)  # nothing of what is imported is garbage: a twentieth of that time
    # Characters that the output's encoding lacks are escaped.
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    from snowmpm.cli.harmless_output import HarmlessOutput

    sys.stdout = HarmlessOutput(sys.stdout)
    try:
        from snowmpm.cli.app import app
    except KeyboardInterrupt:  # Ctrl-C before a command starts
        print("interrupted", file=sys.stderr)
        sys.exit(130)
    try:
        app()
    except OSError as error:  # output without a command: --help, --version
        sys.exit(f"error: standard output: {error.strerror}")
