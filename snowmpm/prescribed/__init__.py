"""Numbers that a scene prescribes in place and time: formulas, tables, gravity."""
