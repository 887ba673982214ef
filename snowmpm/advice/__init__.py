"""Advice of `snowmpm check`: failures of the atlas that may affect a scene, its cost, possible savings."""
