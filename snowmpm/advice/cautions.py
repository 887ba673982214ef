"""Corners of the atlas that a scene sits in: one rule a failure, by the borders that were measured."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowmpm.borders import shipped

RULES = {"mpm": [], "sph": []}
"""By method, in the order in which they are asked."""


DRAWN_CELLS = 2.0
"""Cells through a weak layer of which one row collapses first; more of them break for less energy."""


@dataclass(frozen=True)
class Caution:
    """entry: of the atlas; key: of the scene; says: what lies beyond which border; cure: settings."""

    entry: str
    key: str
    says: str
    cure: str

    def __str__(self):
        return f"{self.key}: {self.says} (atlas: {self.entry}); {self.cure}"


def cautions(facts):
    """`Caution`s of a scene (`SceneFacts`), in the order of the rules."""
    return [caution for rule in RULES[facts.scene.solver.method] for caution in rule(facts)]


def rule(*methods):
    """Mark a generator of cautions about scenes of these methods."""
    def marked(function):
        for method in methods:
            RULES[method].append(function)
        return function
    return marked


def _beyond(entry, setting, value):
    """The border of an entry with a setting when `value` lies on its failing side, else None."""
    border = shipped()[entry, setting]
    return border if border.failing(value) else None


def _of(border, key, value, what=None):
    """A caution in the usual words: `what` is value, beyond the border."""
    unit = f" {border.unit}" if border.unit else ""
    limit = f"{border.value:.3g}{unit}" if border.value is not None else "any"
    side = "over" if border.fails == "above" else "under"
    says = f"{what or border.parameter} {value:.3g}{unit} is {side} {limit}: {border.in_a_sentence}"
    return Caution(border.entry, key, says, border.cure)


@rule("mpm")
def null_space_noise(facts):
    """Motion that the grid does not see, which FLIP's share lets grow."""
    solver = facts.scene.solver
    if "flip" in solver.transfer:
        setting = "flip cubic" if solver.transfer == "flip" and solver.kernel == "cubic" else solver.transfer
        if border := _beyond("null_space_noise", setting, solver.flip_ratio):
            yield _of(border, "solver.flip_ratio", solver.flip_ratio)


@rule("mpm")
def damped_waves(facts):
    """PIC, or little FLIP: the longest wave that a body can have, twice as long as itself."""
    solver = facts.scene.solver
    settings = {"pic": [("pic", 0.0)], "flip": [("flip 0.95", 0.95), ("flip 0.99", 0.99)]}.get(solver.transfer, [])
    known = [name for name, ratio in settings if solver.transfer == "pic" or solver.flip_ratio <= ratio]
    longest = 2.0 * max(facts.extent(body) for body in range(len(facts.scene.bodies)))
    if known and (border := _beyond("damped_waves", known[0], longest)):
        yield _of(border, "solver.transfer", longest, f"{solver.transfer}: the longest wave of a body,")


@rule("mpm")
def lost_spin(facts):
    """Turning that transfers without an affine part take away."""
    solver = facts.scene.solver
    if solver.transfer in ("pic", "flip"):
        ratio = solver.flip_ratio if solver.transfer == "flip" else 0.0
        if border := _beyond("lost_spin", solver.transfer, ratio):
            yield _of(border, "solver.transfer", ratio, f'"{solver.transfer}" with flip_ratio')


@rule("mpm")
def cell_crossing(facts):
    """Jumps of the stress when a particle crosses into the next cell."""
    solver = facts.scene.solver
    basis = "cubic shape" if solver.kernel == "cubic" else f"quadratic {solver.gradient}"
    if border := _beyond("cell_crossing", basis, 1.0 / facts.per_axis):
        yield _of(border, "solver.particles_per_cell", 1.0 / facts.per_axis)


@rule("mpm")
def numerical_fracture(facts):
    """Bodies tear when they are drawn out: what a scene will stretch is not known, but one particle a cell is torn by
    any stretch at all."""
    if facts.per_axis < 1.5 and facts.scene.solver.kernel == "quadratic":
        border = shipped()["numerical_fracture", "quadratic 1"]
        if border.failing(border.lowest):
            yield _of(border, "solver.particles_per_cell", border.lowest)


@rule("mpm")
def volumetric_locking(facts):
    """Too stiff an answer of nearly incompressible or dilating snow, with many particles in a cell."""
    solver = facts.scene.solver
    many = solver.kernel == "quadratic" and solver.gradient == "affine" and facts.per_axis > 2.5
    for name, law in zip(facts.scene.materials, facts.model.laws, strict=True):
        ratio = law.bulk_modulus / law.shear_modulus
        if border := _beyond("volumetric_locking", f"{facts.spline} {9 if many else 4}", ratio):
            nu = (3.0 * border.value - 2.0) / (6.0 * border.value + 2.0)
            what = f"{law.poisson_ratio:g} (border {nu:.3f}): K / G"
            yield _of(border, f"materials.{name}.poisson_ratio", ratio, what)


@rule("mpm")
def stiffness_contrast(facts):
    """A stiff body on a soft one within a cell or two."""
    for pair in facts.pairs:
        if pair.distance == 0 and not pair.separate:
            first, second = (facts.law(body).youngs_modulus for body in (pair.first, pair.second))
            contrast = max(first, second) / min(first, second)
            setting = "cubic" if facts.scene.solver.kernel == "cubic" else (
                "shape" if facts.scene.solver.gradient == "shape" else "quadratic")
            if border := _beyond("stiffness_contrast", setting, contrast):
                names = " and ".join(facts.scene.bodies[body].name for body in (pair.first, pair.second))
                yield _of(border, f"bodies ({names})", contrast)


@rule("mpm")
def thin_layer(facts):
    """A soft layer between stiffer bodies, by the contrast to the softest of them."""
    for body, spec in enumerate(facts.scene.bodies):
        others = [pair.second if pair.first == body else pair.first for pair in facts.pairs
                  if body in (pair.first, pair.second) and pair.distance == 0]
        own = facts.law(body).youngs_modulus
        stiffer = [facts.law(other).youngs_modulus / own for other in others if facts.law(other).youngs_modulus > own]
        if not stiffer:
            continue
        known = {5.0: "1 : 5", 20.0: "1 : 20" if facts.spline == "quadratic" else f"1 : 20 {facts.spline.split()[-1]}"}
        for contrast, setting in sorted(known.items(), reverse=True):
            if min(stiffer) >= contrast:
                if border := _beyond("thin_layer", setting, facts.thickness(body)):
                    yield _of(border, f"bodies.{body} ({spec.name})", facts.thickness(body))
                break


@rule("mpm")
def shallow_flow(facts):
    """Layers of snow on ground that they may slide on: by their depth at the start."""
    if not any(body.shape.kind == "layer" for body in facts.scene.bodies):
        return
    depth = facts.model.depth / facts.dx
    setting = {"aflip": "aflip 0.99", "flip": "flip 0.99"}.get(facts.scene.solver.transfer, facts.scene.solver.transfer)
    if border := _beyond("shallow_flow", setting, depth):
        yield _of(border, "solver.dx", depth)


@rule("mpm")
def early_contact(facts):
    """Bodies that stand apart and come together: they will meet that much too early."""
    for pair in facts.pairs:
        first, second = (facts.scene.bodies[body] for body in (pair.first, pair.second))
        differ = np.linalg.norm(np.subtract(first.velocity, second.velocity)) > 1e-3 * facts.wave_speed
        if pair.distance == 0 and not differ:
            continue
        setting = ("separate" if pair.separate else "shared") + (" cubic" * (facts.scene.solver.kernel == "cubic"))
        if not pair.separate and (border := _beyond("early_contact", setting, float(pair.distance))):
            yield _of(border, f"bodies ({first.name} and {second.name})", float(pair.distance))


@rule("mpm")
def thin_obstacle(facts):
    """An obstacle thinner than the grid can keep snow from passing."""
    setting = "cubic" if facts.scene.solver.kernel == "cubic" else "between nodes"
    for i, obstacle in enumerate(facts.model.obstacles):
        thickness = 2.0 * float(np.min(obstacle.shape.size)) / facts.dx
        if border := _beyond("thin_obstacle", setting, thickness):
            yield _of(border, f"obstacles.{i} ({obstacle.name})", thickness)


@rule("mpm")
def fixed_steps(facts):
    """What an adaptive step would see to."""
    dt = facts.scene.solver.dt
    if dt is None:
        return
    speed = max(facts.start_speed, facts.fall_speed)
    if border := _beyond("crossing_step", facts.scene.solver.kernel, speed * dt / facts.dx):
        yield _of(border, "solver.dt", speed * dt / facts.dx, "at the speed of a fall,")
    share = dt / facts.solver.critical_dt()[0]
    setting = "elastic step 0.8" if share > 0.5 else "elastic step 0.4"
    if border := _beyond("fast_impact", setting, speed / facts.wave_speed):
        yield _of(border, "solver.dt", speed / facts.wave_speed)


@rule("mpm", "sph")
def far_from_origin(facts):
    """Meshes whose vertices are stored in float32."""
    named = [("terrain.file", facts.scene.terrain)]
    named += [(f"obstacles.{i}.shape.file", obstacle.shape) for i, obstacle in enumerate(facts.scene.obstacles)]
    for key, spec in named:
        if spec is None or spec.kind != "mesh" or not _is_binary_stl(facts.scene.base_dir / spec.file):
            continue
        farthest = max(np.abs(facts.model.lower).max(), np.abs(facts.model.upper).max()) / facts.dx
        if border := _beyond("far_from_origin", "binary STL", farthest):
            yield _of(border, key, farthest)


def _is_binary_stl(path):
    path = Path(path).expanduser()
    if path.suffix.lower() != ".stl":
        return False
    with open(path, "rb") as file:
        return not file.read(6).lower().startswith(b"solid ")


@rule("mpm")
def small_strains(facts):
    """Strains so small that the precision does not carry them."""
    if facts.least_strain > 0.0:
        precision = facts.scene.solver.precision
        if border := _beyond("small_strains", precision, facts.least_strain):
            yield _of(border, "solver.precision", facts.least_strain)


@rule("mpm", "sph")
def apex(facts):
    """Return maps whose error grows with the step: strain of a step at the fastest motion of the start."""
    strain = facts.start_speed / facts.wave_speed * facts.solver.cfl
    for name, law in zip(facts.scene.materials, facts.model.laws, strict=True):
        if getattr(law, "return_map", None) == "frozen" and (border := _beyond("apex", "cap, frozen", strain)):
            yield _of(border, f"materials.{name}.return_map", strain)


@rule("mpm")
def softening_on_grid(facts):
    """A weak layer whose energy follows the grid: one that softens, with no thickness of reference. Where the grid is
    that of the tuning nothing is wrong; so it is said only of a layer of more cells than collapse as one."""
    for body, spec in enumerate(facts.scene.bodies):
        law = facts.scene.materials[spec.material]
        if getattr(law, "softening", None) and getattr(law, "reference_thickness", None) is None:
            border = shipped()["softening_on_grid", "as given"]
            ratio = DRAWN_CELLS / facts.thickness(body)
            if border.failing(ratio):
                yield _of(border, f"materials.{spec.material}.reference_thickness", ratio,
                          f"{facts.thickness(body):.3g} cells through the layer, of which single rows collapse;"
                          " spacing over that of two cells")


@rule("sph")
def sph_pairing(facts):
    """Particles that pair under compression, with this kernel and this many neighbours."""
    chosen = facts.scene.solver.sph
    if border := _beyond("sph_pairing", chosen.kernel.replace("_", " "), chosen.smoothing):
        yield _of(border, "solver.sph.kernel", chosen.smoothing)


@rule("sph")
def sph_free_surface(facts):
    """Stresses at a free surface with gradients that are not corrected."""
    chosen = facts.scene.solver.sph
    if chosen.gradient == "plain":
        setting = min((1.2, 1.5, 2.0), key=lambda h: abs(h - chosen.smoothing))
        if border := _beyond("sph_free_surface", f"plain {setting:g}", 0.5):
            yield _of(border, "solver.sph.gradient", 0.5)


@rule("sph")
def sph_tensile(facts):
    """Materials that bear tension, where nothing acts against it: the strength of cohesive ones, the load of those
    without an end."""
    chosen = facts.scene.solver.sph
    if chosen.disorder_damping > 0.0 or chosen.artificial_stress > 0.0:
        return
    for name, law in zip(facts.scene.materials, facts.model.laws, strict=True):
        modulus = law.density * law.wave_speed() ** 2
        strength = getattr(law, "cohesion", None)
        if law.kind == "elastic":
            pulled = facts.least_strain
        elif strength and hasattr(law, "p0"):
            pulled = strength * law.p0 / modulus
        else:
            continue
        if border := _beyond("sph_tensile", "wendland c6 1.5", pulled):
            yield _of(border, f"materials.{name}", pulled)


@rule("sph")
def sph_wall(facts):
    """Fast particles, where no barrier stops them."""
    if facts.scene.solver.sph.barrier:
        return
    speed = max(facts.start_speed, facts.fall_speed) / facts.wave_speed
    if border := _beyond("sph_wall", "mirrored", speed):
        yield _of(border, "solver.sph.barrier", speed)
