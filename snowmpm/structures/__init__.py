"""Elastic structures in the snow: masts and posts that bend, yield and break."""
