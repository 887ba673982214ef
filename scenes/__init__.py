"""scenes of snowmpm."""

if __name__ != "snowmpm.scenes":
    raise ImportError("import this package as snowmpm.scenes")
