"""Pictures and films of runs. Reads run files only: needs neither Taichi nor a solver, a display or a graphics card."""

if __name__ != "snowmpm.render":
    raise ImportError("import this package as snowmpm.render")

from snowmpm.render.run_film import render_run

__all__ = ["render_run"]
