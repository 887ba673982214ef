"""What is made of a run: maps, hazard numbers, compression."""
