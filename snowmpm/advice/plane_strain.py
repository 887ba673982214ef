"""Whether a 3-D scene is in plane strain, extruded along y."""

import numpy as np

from snowmpm import components

ALIKE = 0.02
"""Share of the cells of a cross-section that may differ in plane strain."""


def is_plane_strain(facts):
    """Whether a 3-D scene does not change along y: all slices of cells are alike, terrain and obstacles are extruded
    along y, nothing moves along y, and the sides at both ends prevent such motion."""
    scene = facts.scene
    if scene.domain is None or scene.saw_test:
        return False
    sides = scene.domain.sides(3)
    smooth = {"periodic", "slip", "symmetric"}
    if sides["y_min"] not in smooth or sides["y_max"] not in smooth:
        return False
    if scene.gravity_vector[1] or np.abs(facts.model.population.velocities[:, 1]).max(initial=0.0) > 0.0:
        return False
    if scene.events or any(component.solid for component in components.used(scene)) or any(
            not _drawn_out(obstacle, facts) for obstacle in scene.obstacles):
        return False
    across = facts.model.population.positions[:, 1]
    if across.min() > facts.model.lower[1] + facts.dx or across.max() < facts.model.upper[1] - facts.dx:
        return False
    cells = np.floor(facts.model.population.positions / facts.dx).astype(np.int64)
    rows = np.unique(cells[:, 1])
    sections = [set(map(tuple, cells[cells[:, 1] == row][:, [0, 2]])) for row in rows]
    whole = set().union(*sections)
    if max(len(whole - section) for section in sections) > ALIKE * len(whole):
        return False
    surface = facts.model.surface
    if surface is None:
        return True
    lower, upper = facts.model.lower, facts.model.upper
    x = np.linspace(lower[0], upper[0], 41)[1:-1]
    lines = np.linspace(lower[1], upper[1], 7)[1:-1]
    heights = [surface.height(np.column_stack([x, np.full_like(x, y)])) for y in lines]
    spread = np.nanmax(np.ptp(np.array(heights), axis=0), initial=0.0)
    return bool(spread < 0.01 * facts.dx)


def _drawn_out(obstacle, facts):
    if obstacle.shape.kind != "box" or (obstacle.motion and (obstacle.motion.velocity[1] or any(
            obstacle.motion.angular_velocity[axis] for axis in (0, 2)))):
        return False
    return obstacle.shape.min[1] <= facts.model.lower[1] and obstacle.shape.max[1] >= facts.model.upper[1]
