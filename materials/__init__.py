"""materials of snowmpm."""

if __name__ != "snowmpm.materials":
    raise ImportError("import this package as snowmpm.materials")
