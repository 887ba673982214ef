"""Bodies in velocity fields of their own, which slide on each other and part."""
