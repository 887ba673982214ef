"""What the laws ask of the compiler that builds them. `snowmpm.compiler` puts itself in place when it is imported.

Laws are Taichi functions, and take constants that depend on the float that a kernel is compiled for. Only
the compiler's inner part, which `snowmpm.compiler` alone names, knows which one that is.
"""

_compiler = None


def provide(compiler):
    """Use this compiler: an object with `working_float()`, "f32" or "f64", and `working_precision(name)`, a context in
    which kernels are compiled and launched for one of them."""
    global _compiler
    _compiler = compiler


def compiler():
    """The compiler. Raises RuntimeError when none was started: importing a law must never start it."""
    if _compiler is None:
        raise RuntimeError("Taichi is not running: call snowmpm.start() first")
    return _compiler
