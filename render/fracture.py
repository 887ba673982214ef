"""The weak layer of a run: which snow it is, how far it has failed, and what lies over it."""

from dataclasses import dataclass

import numpy as np
from matplotlib.colors import LinearSegmentedColormap

from snowmpm.errors import InputError
from snowmpm.render.colour import ColourScale
from snowmpm.render.framing import downhill

NAME = "fracture"  # the colour that asks for it
WEAK = "anticrack_cam_clay"
FLAT = 0.02  # slope below which there is no way down
CRACK = LinearSegmentedColormap.from_list("crack", ["#7fb2d9", "#b9cfe0", "#f3d9a0", "#ef7d38", "#c4202f"])


@dataclass(frozen=True)
class WeakLayer:
    """Numbers, in the field `material` of a run, of the weak layer's material and of those of the snow over it."""

    weak: int
    over: tuple[int, ...]

    @classmethod
    def of(cls, run):
        """Of a run whose scene has one: the body that a cut goes through, or whose law is that of a weak layer.

        Raises InputError for a scene without one, and for a run that does not hold the fields that show it.
        """
        try:
            scene = run.scene if "scene" in run.provenance else {}
            bodies, weak = _bodies(scene), _weak(scene)
        except (InputError, LookupError, TypeError, AttributeError):
            raise InputError(f"{run.path}: its scene cannot be read, so its weak layer is not known") from None
        materials = list(run.provenance.get("materials", scene.get("materials", {})))
        if not weak:
            raise InputError(f"{run.path}: no weak layer: none of its bodies is cut, or of kind {WEAK}")
        for name in ("material", "damage"):
            if name not in run.field_names:
                raise InputError(f"{run.path}: no field {name}, which shows the weak layer: add it to output.fields of"
                                 " the scene")
        top = weak[0]["shape"].get("top", np.inf)
        over = {body["material"] for body in bodies if body["shape"].get("bottom", -np.inf) >= top}
        own = weak[0]["material"]
        return cls(materials.index(own), tuple(materials.index(name) for name in over - {own} if name in materials))

    def scale(self):
        """Colours of its damage."""
        return ColourScale("damage", "damage of the weak layer", "", 0.0, 1.0, CRACK)

    def colours(self, frame, table, plain):
        """Colours (n, 3) in linear light: the weak layer by its damage from `table` (256, 3), all else `plain` (3,)."""
        share = np.clip(np.nan_to_num(frame.fields["damage"]), 0.0, 1.0)
        chosen = table[np.round(255 * share).astype(int)]
        return np.where((frame.fields["material"] == self.weak)[:, None], chosen, plain).astype(np.float32)


@dataclass(frozen=True)
class Cutaway:
    """A vertical plane along the flow: on the side of the camera what lies over the weak layer is left out.

    point, normal: (2,) of the plane in plan, the normal towards the camera
    """

    layer: WeakLayer
    point: np.ndarray
    normal: np.ndarray

    @classmethod
    def of(cls, run, layer, camera):
        """Through the middle of what lies over the weak layer at first, downhill, or on the flat along its length.

        Raises InputError where nothing lies over it.
        """
        frame = run.frame(0, ["material"])
        over = np.isin(frame.fields["material"], layer.over)
        if not over.any():
            raise InputError(f"{run.path}: nothing lies over the weak layer, so there is nothing to cut away")
        point = frame.points[over, :2].mean(axis=0).astype(float)
        along = downhill(frame.points[over].astype(float))
        if np.linalg.norm(along) < FLAT:
            plan = frame.points[over, :2] - point
            along = np.linalg.eigh(plan.T @ plan)[1][:, 1]
        normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
        to_camera = camera.eye[:2] - point if camera.perspective else -camera.axes[2, :2]
        return cls(layer, point, normal if normal @ to_camera >= 0.0 else -normal)

    def shown(self, frame):
        """Which particles (n,) of a frame with its field `material` are drawn."""
        beside = frame.points[:, :2] - self.point.astype(np.float32)
        near = np.einsum("ni,i->n", beside, self.normal.astype(np.float32)) > 0.0
        return ~(near & np.isin(frame.fields["material"], self.layer.over))


def _weak(scene):
    """Bodies that a cut goes through, or else whose law is that of a weak layer."""
    cut = [event["body"] for event in scene.get("events", []) if event["kind"] == "cut"]
    cut += ["weak_layer"] if "saw_test" in scene else []
    laws, bodies = scene.get("materials", {}), _bodies(scene)
    return [body for body in bodies if body["name"] in cut] or [
        body for body in bodies if laws.get(body["material"], {}).get("kind") == WEAK]


def _bodies(scene):
    """Bodies of a resolved scene, those that a saw test makes included."""
    if "saw_test" not in scene:
        return scene.get("bodies", [])
    test = scene["saw_test"]
    slab = [{"name": "slab", "material": layer["material"], "shape": {"bottom": 1.0}} for layer in test.get("slab", [])]
    return [{"name": "weak_layer", "material": test["weak_layer"]["material"], "shape": {"top": 1.0}}, *slab]
