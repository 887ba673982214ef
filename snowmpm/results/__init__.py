"""Results derived from a run: maps, hazard numbers, compression."""
