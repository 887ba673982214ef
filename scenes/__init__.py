"""Scenes of snowmpm: schema and loader of scene files, library scenes, material cards."""

if __name__ != "snowmpm.scenes":
    raise ImportError("import this package as snowmpm.scenes")

from snowmpm.scenes.cards import MaterialCard, material_card, material_cards
from snowmpm.scenes.friction_cards import FrictionCard, friction_card, friction_cards
from snowmpm.scenes.library import library
from snowmpm.scenes.loader import load_scene
from snowmpm.scenes.schema import Scene

__all__ = ["FrictionCard", "MaterialCard", "Scene", "friction_card", "friction_cards", "library", "load_scene",
           "material_card", "material_cards"]
