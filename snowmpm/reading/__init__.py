"""Files that anybody may have written, read within bounds: a budget of memory, TOML, tables of numbers."""
