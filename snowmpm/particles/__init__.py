"""The particles of a simulation: what each carries, where it lies in memory, which block it belongs to."""
