"""render of snowmpm."""

if __name__ != "snowmpm.render":
    raise ImportError("import this package as snowmpm.render")
