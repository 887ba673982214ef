"""BM-1: a column of grains collapses against an upright wall, stiff or flexible, with two ways of coupling.

The sizes are those of the case: soil 200 x 100 mm against the left side, a wall of 10 x 100 mm, 100 mm away, sides and
floor that stick; soil of Mohr-Coulomb, rubber of 1 MPa. One body: soil and wall share the grid's velocities, so that
they stick to each other wherever they come near. Parts: the wall is a structure that the snow may leave.
"""

from snowmpm.scenes.schema import Scene

SOIL = {"kind": "mohr_coulomb", "density": 2650.0, "youngs_modulus": 8.4e5, "poisson_ratio": 0.3,
        "friction_angle": 19.8, "cohesion": 0.0, "dilation_angle": 0.0}
RUBBER = {"kind": "elastic", "density": 1100.0, "youngs_modulus": 1e6, "poisson_ratio": 0.0}
THICK, HIGH, FACE = 0.01, 0.1, 0.3


def wall(modulus=1e6, **more):
    """The wall as a structure."""
    return {"name": "wall", "foot": [FACE + 0.5 * THICK, 0.0], "top": [FACE + 0.5 * THICK, HIGH], "width": THICK,
            "youngs_modulus": modulus, "density": 1100.0, "segments": 10, "damping": 0.0, "contact": "separate",
            "friction": 0.5, "coupling": "strong", **more}


def scene(dx, one_body, end_time=1.0, modulus=1e6, per_cell=4, **more):
    """`Scene` on a grid of dx [m]; one_body: the wall is a body that sticks; modulus of the wall [Pa]."""
    bodies = [{"name": "soil", "material": "soil",
               "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.2, 0.1]}}]
    if one_body:
        bodies.append({"name": "wall", "material": "rubber",
                       "shape": {"kind": "box", "min": [FACE, 0.0], "max": [FACE + THICK, HIGH]}})
    materials = {"soil": SOIL, "rubber": {**RUBBER, "youngs_modulus": modulus}}
    return Scene.model_validate({
        "name": "column_against_wall", "dimension": 2, "end_time": end_time, "gravity": 9.81,
        "output": {"interval": 0.005}, "solver": {"dx": dx, "precision": "f64", "particles_per_cell": per_cell},
        "domain": {"min": [0.0, 0.0], "max": [0.6, 0.2], "boundary": {"x_min": "stick", "z_min": "stick"}},
        "materials": materials if one_body else {"soil": SOIL}, "bodies": bodies,
        "structures": [] if one_body else [wall(modulus)], **more})
