"""Observed avalanches: what is known of each, its files, and how near a run comes to it."""
