"""The atlas of failures: where each scheme fails, how, and which settings cure it."""
