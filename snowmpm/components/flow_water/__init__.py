"""Water in a depth-averaged flow, and excess pore pressure over its depth."""
