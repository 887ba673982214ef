"""Masts and frameworks that bend in the snow."""
