"""`snowmpm check`: is a scene valid, and what would be modelled."""

from snowmpm.cli.options import Json, PrecisionOption, SceneName, Settings, scene_overrides
from snowmpm.cli.table import print_facts, print_json


def check(scene: SceneName, settings: Settings = None, precision: PrecisionOption = None, as_json: Json = False):
    """Say what a scene will model, and at what expense.

    Writes nothing. A wrong scene ends with exit code 2 and the key that is wrong.
    """
    from snowmpm.cli.options import Backend
    from snowmpm.cli.run import start_taichi
    from snowmpm.scenes import load_scene

    loaded = load_scene(scene, scene_overrides(settings, precision))
    start_taichi(Backend.cpu, None)
    from snowmpm import build

    described = build.describe(loaded)
    if as_json:
        print_json({"scene": loaded.name, "source": loaded.source, **described})
    else:
        print_facts(f"{loaded.name} ({loaded.source})", described)
