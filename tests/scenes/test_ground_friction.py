"""Friction of the ground in a scene: number, law, card, choice by volume; and what a user reads when it is wrong."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from snowmpm.advice.cautions.ground_friction import class_of_friction
from snowmpm.cli.app import app
from snowmpm.errors import InputError
from snowmpm.ground import LAWS, Coulomb, SamosAt, Voellmy
from snowmpm.ground.friction import GroundFriction
from snowmpm.io.parameters import parameters
from snowmpm.methods import METHODS, Capabilities, MethodEntry
from snowmpm.running.friction_class import class_chosen
from snowmpm.scenes import friction_card, friction_cards, load_scene
from snowmpm.scenes.friction import ByVolume
from snowmpm.scenes.friction_cards import FOLDER, law_for_volume
from snowmpm.setup.build import build
from snowmpm.setup.refusals import refuse_beyond
from tests.support.registered import registered

SCENE = """
name = "sheet"
dimension = %d
end_time = 1.0
solver = { dx = 1.0 }
domain = { min = [%s], max = [%s] }

[terrain]
kind = "plane"
%s

[[bodies]]
name = "snow"
material = "li_cold_dense"
shape = { kind = "box", min = [%s], max = [%s] }
"""


@pytest.fixture
def written(tmp_path):
    """Writes a scene on a level plane with these lines of its terrain, and a block of 4 x 4 x 2 m."""

    def write(lines, dimension=3):
        def corner(x, z):
            return ", ".join([str(x)] * (dimension - 1) + [str(z)])

        path = tmp_path / "scene.toml"
        path.write_text(SCENE % (dimension, corner(0.0, -2.0), corner(8.0, 8.0), lines, corner(2.0, 0.0),
                                 corner(6.0, 2.0)))
        return path

    return write


def message(path):
    with pytest.raises(InputError) as caught:
        load_scene(path)
    return str(caught.value).removeprefix(f"{path}: ")


# ---- what may be written --------------------------------------------------------------------------------------------


def test_a_number_stays_coulomb(written):
    assert load_scene(written("")).terrain.friction == 0.3
    scene = load_scene(written("friction = 0.5"))
    assert scene.terrain.friction == 0.5 and "friction = 0.5" in scene.to_toml()
    refuse_beyond(scene)
    model = build(scene)
    assert model.friction.law == Coulomb(mu=0.5)
    assert model.friction.on_nodes([1.0], [2.0])[:, 0] == pytest.approx([0.5, 0.0, 0.0])


def test_a_table_names_a_law_and_survives_the_resolved_scene(written, tmp_path):
    (tmp_path / "mu.asc").write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n0.1 0.2\n0.3 0.4\n")
    lines = '[terrain.friction]\nlaw = "voellmy"\nmu = { file = "mu.asc" }\nxi = 2000\ntau0 = 20.0'
    scene = load_scene(written(lines))
    law = scene.terrain.friction
    assert isinstance(law, Voellmy) and (law.xi, law.tau0, list(law.rasters)) == (2000.0, 20.0, ["mu"])
    again = tmp_path / "elsewhere" / "resolved.toml"
    again.parent.mkdir()
    again.write_text(scene.to_toml())
    resolved = load_scene(again)
    assert resolved.terrain.friction.mu.file == str(tmp_path / "mu.asc")  # wherever it lies
    assert resolved.to_toml() == scene.to_toml()


@pytest.mark.parametrize("name", sorted(friction_cards()))
def test_every_card_loads_in_a_scene(written, name):
    friction = load_scene(written(f'friction = {{ card = "{name}" }}')).terrain.friction
    assert friction.card == name
    assert isinstance(friction, ByVolume) if friction_card(name).classes else friction == friction_card(name).friction


def test_numbers_beside_a_card_override_it(written):
    law = load_scene(written('friction = { card = "samos_at_medium", tau0 = 50.0 }')).terrain.friction
    assert law == SamosAt(mu=0.17, tau0=50.0, began_with="samos_at_medium")


def test_the_drag_in_its_other_form(written, tmp_path):
    """k = g/xi, a number or a raster, also beside a card that gives xi."""
    by_xi, by_k = (load_scene(written(f'friction = {{ law = "voellmy", mu = 0.2, {drag} }}')).terrain.friction
                   for drag in ("xi = 2000.0", "k = 0.004905"))
    assert by_xi.parameters(9.81) == pytest.approx(by_k.parameters(9.81)) and by_k.xi is None
    card = load_scene(written('friction = { card = "voellmy_avaframe", k = 0.003 }')).terrain.friction
    assert (card.k, card.xi, card.card, card.began_with) == (0.003, None, None, "voellmy_avaframe")
    head = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 100\n"
    (tmp_path / "k.asc").write_text(head + 2 * "0.002 0.004\n")
    scene = load_scene(written('friction = { law = "voellmy", mu = 0.2, k = { file = "k.asc" } }'))
    found = GroundFriction(scene.terrain.friction, tmp_path).on_nodes(np.array([50.0, 150.0]), np.array([50.0, 50.0]))
    assert found[1] == pytest.approx([0.002, 0.004])
    assert load_scene(written(f"friction = {{ law = \"voellmy\", mu = 0.2, k = {{ file = '{tmp_path / 'k.asc'}' }} }}"))


def test_the_numbers_of_a_card_as_they_are_keep_its_name(written):
    law = load_scene(written('friction = { card = "samos_at_medium", mu = 0.17 }')).terrain.friction
    assert (law.card, law.began_with) == ("samos_at_medium", None)


def handed_over(scene, capabilities):
    """The friction that the builder of a method with these capabilities gets."""
    got = {}
    with registered(MethodEntry("mpm", lambda *_, **common: got.update(common), capabilities)):
        model = build(scene)
        model.solver()
    return got["terrain_friction"]


def test_coulomb_is_a_number_to_methods_that_know_no_other_law(written, tmp_path):
    for lines in ("friction = 0.4", 'friction = { law = "coulomb", mu = 0.4 }'):
        assert handed_over(load_scene(written(lines)), METHODS["mpm"].capabilities) == 0.4
    law = handed_over(load_scene(written('friction = { card = "voellmy_avaframe" }')),
                      Capabilities(ground_friction=("coulomb", "voellmy")))
    assert law.law == friction_card("voellmy_avaframe").friction and law.base_dir == tmp_path


# ---- what is refused ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("lines", "says"), [
    ("friction = -0.1", "terrain.friction = -0.1: must be >= 0"),
    ('friction = "0.3"', 'terrain.friction = "0.3": must be a number'),
    ('friction = { law = "voelmy", mu = 0.2 }', 'terrain.friction.law = "voelmy": must be one of "coulomb", "voellmy", '
     '"samos_at", "frictional_viscous", "bingham", "mu_i", "by_volume"; did you mean voellmy?'),
    ("friction = { mu = 0.2 }", 'terrain.friction.law is missing: one of "bingham", "by_volume", "coulomb", '
     '"frictional_viscous", "mu_i", "samos_at", "voellmy"'),
    ('friction = { law = "voellmy", mu = 0.2 }', "terrain.friction.xi is missing: coefficient of turbulent friction"
     " [m/s2]"),
    ('friction = { law = "voellmy", mu = 12.0, xi = 2e3 }', "terrain.friction.mu = 12.0: must be <= 10"),
    ('friction = { law = "voellmy", mu = -1.0, xi = 2e3 }', "terrain.friction.mu = -1.0: must be >= 0"),
    ('friction = { law = "voellmy", mu = "0.2", xi = 2e3 }', 'terrain.friction.mu = "0.2": must be a number'),
    ('friction = { law = "voellmy", mu = 0.2, chi = 2e3 }', "terrain.friction.chi = 2000.0: unknown key; known here:"
      " began_with, card, cohesion, k, law, mu, tau0, xi"),
    ('friction = { law = "voellmy", mu = 0.2, xi = 2e3, k = 0.005 }', "terrain.friction.k = 0.005: does not go with xi,"
     " of which it is g/xi: leave one of them out"),
    ('friction = { law = "voellmy", mu = 0.2, k = 12.0 }', "terrain.friction.k = 12.0: must be <= 10"),
    ('friction = { law = "coulomb", mu = { file = "mu.tif" } }', 'terrain.friction.mu.file = "mu.tif": no such file'),
    ('friction = { law = "coulomb", mu = { fil = "mu.tif" } }', 'terrain.friction.mu.fil = "mu.tif": unknown key'),
    ('friction = { law = "mu_i", mu_s = 0.4, mu_2 = 0.3, grain_diameter = 0.1, grain_density = 4e2 }',
     "mu_2 must not be below mu_s"),
    ('friction = { card = "samos_at_mediun" }', 'terrain.friction.card = "samos_at_mediun": no such friction card: did'
     " you mean samos_at_medium?"),
    ('friction = { card = "samos_at_auto", mu = 0.2 }', "terrain.friction.mu = 0.2: unknown key"),
    ('friction = { law = "by_volume", card = "voellmy_avaframe", mu = 0.2 }', "unknown key"),
])
def test_what_is_wrong_is_said_in_two_lines(written, lines, says):
    path = written(lines)
    text = message(path)
    assert says in text and text.count("\n") <= 1
    done = CliRunner().invoke(app, ["check", str(path)])
    assert done.exit_code == 2


def test_rasters_and_volumes_need_three_dimensions(written, tmp_path):
    (tmp_path / "mu.asc").write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n0.1 0.2\n0.3 0.4\n")
    raster = 'friction = { law = "coulomb", mu = { file = "mu.asc" } }'
    assert "exists only in a 3-D scene" in message(written(raster, 2))
    assert "exists only in a 3-D scene" in message(written('friction = { card = "samos_at_auto" }', 2))


@pytest.mark.parametrize("method", ["sph"])
@pytest.mark.parametrize(("friction", "key"), [
    ('{ card = "samos_at_small" }', 'terrain.friction.law = .samos_at.: needs solver.method .*which has coulomb only'),
    ('{ card = "samos_at_auto" }', 'terrain.friction.law = .samos_at.: needs solver.method'),
    ('{ law = "coulomb", mu = 0.3, tau0 = 70.0 }', "terrain.friction.tau0 = 70.0: needs solver.method"),
    ('{ law = "coulomb", mu = 0.3, cohesion = 50.0 }', "terrain.friction.cohesion = 50.0: needs solver.method"),
    ('{ law = "coulomb", mu = { file = "mu.asc" } }', "terrain.friction.mu.file = .mu.asc.: needs solver.method"),
])
def test_methods_refuse_what_they_cannot(written, tmp_path, method, friction, key):
    (tmp_path / "mu.asc").write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n0.1 0.2\n0.3 0.4\n")
    scene = load_scene(written(f"friction = {friction}"), {"solver.method": method})
    with pytest.raises(InputError, match=key) as caught:
        refuse_beyond(scene)
    assert "\n" not in str(caught.value)


def test_methods_that_can_are_named(written):
    able = Capabilities(ground_friction=("coulomb", "voellmy"))
    path = written('friction = { card = "voellmy_avaframe" }')
    with registered(MethodEntry("sheets", lambda *_: None, able)):
        with pytest.raises(InputError, match=r'needs solver.method = .*"sheets" in place of "sph"'):
            refuse_beyond(load_scene(path, {"solver.method": "sph"}))
        refuse_beyond(load_scene(path, {"solver.method": "sheets"}))


# ---- cards ----------------------------------------------------------------------------------------------------------

NUMBERS = {
    # com1DFACfg.ini of AvaFrame 2.1
    "samos_at_small": ("samos_at", {"mu": 0.22, "Rs0": 0.222, "kappa": 0.43, "R": 0.05, "B": 4.13, "tau0": 0.0}),
    "samos_at_medium": ("samos_at", {"mu": 0.17, "Rs0": 0.222, "kappa": 0.43, "R": 0.05, "B": 4.13, "tau0": 0.0}),
    "samos_at_large": ("samos_at", {"mu": 0.155, "Rs0": 0.222, "kappa": 0.43, "R": 0.05, "B": 4.13, "tau0": 0.0}),
    "samos_at_auto": None,
    "voellmy_avaframe": ("voellmy", {"mu": 0.155, "xi": 4000.0, "tau0": 0.0}),
    "voellmy_min_shear_avaframe": ("voellmy", {"mu": 0.155, "xi": 4000.0, "tau0": 70.0}),
    # abstracts of the papers
    "voellmy_buser_frutiger": ("voellmy", {"mu": 0.155, "xi": 1120.0}),
    "voellmy_buser_frutiger_extreme": ("voellmy", {"mu": 0.16, "xi": 1360.0}),
    "voellmy_martinelli_dry": ("voellmy", {"mu": 0.15, "xi": 0.5 * (1200.0 + 1600.0)}),
}


def test_numbers_of_the_cards_are_those_of_their_sources():
    assert set(friction_cards()) == set(NUMBERS) == {path.stem for path in FOLDER.glob("*.toml")}
    for name, numbers in NUMBERS.items():
        card = friction_card(name)
        assert 20 < len(card.description) < 100 and len(card.validity) > 40
        assert re.search(r"doi:10\.\d{4,}/\S+|J\. Glaciology", card.source)
        if numbers is not None:
            law, values = numbers
            assert type(card.friction) is LAWS[law]
            assert {key: getattr(card.friction, key) for key in values} == values


def test_volume_chooses_the_class():
    auto = friction_card("samos_at_auto")
    mus = [law_for_volume(auto, volume).mu for volume in (0.0, 24999.0, 25000.0, 59999.0, 60000.0, 1e7)]
    assert mus == [0.22, 0.22, 0.17, 0.17, 0.155, 0.155]


def test_a_scene_takes_the_class_of_its_release(written):
    model = build(load_scene(written("friction = 0.3")))  # of a method that can be built
    assert model.release_volume == pytest.approx(32.0)
    model.scene = load_scene(written('friction = { card = "samos_at_auto" }'))
    assert model.friction.law == friction_card("samos_at_small").friction
    assert class_chosen(model) == "samos_at_small"


def test_validity_of_a_class():
    small, large = friction_card("samos_at_small"), friction_card("samos_at_large")
    assert small.doubts(1e4, 1200.0) == [] and small.doubts() == []
    (volume,) = small.doubts(3e4, 1200.0)
    assert volume == "the release has 30\u202f000 m³, and the class is for a volume below 25\u202f000 m³"
    (high,) = small.doubts(1e4, 1700.0)
    assert high == "the flow rests at 1700 m, and the class is for a run-out below 1600 m"
    # before a run: certain only where no ground is lower
    assert small.doubts(1e4, ground=(900.0, 2500.0)) == []
    assert small.doubts(1e4, ground=(1650.0, 2500.0)) == ["no ground lies below 1650 m, and the class is for a run-out"
                                                          " below 1600 m"]
    assert large.doubts(1e5, 1000.0) == [] and len(large.doubts(1e4, 1000.0)) == 1
    assert large.doubts(1e4, 1700.0) == []  # above 1600 m it is the class of every volume


def test_check_warns_of_a_class_that_does_not_fit(written):
    model = build(load_scene(written("friction = 0.3")))
    model.scene = load_scene(written('friction = { card = "samos_at_large" }'))
    facts = SimpleNamespace(scene=model.scene, model=model)
    (caution,) = class_of_friction(facts)
    assert caution.key == "terrain.friction.card" and "samos_at_large: the release has 32 m³" in caution.says
    model = build(load_scene(written("friction = 0.3")))
    assert list(class_of_friction(SimpleNamespace(scene=model.scene, model=model))) == []


def test_check_warns_of_altitude_on_a_raster_only():
    law = friction_card("samos_at_small").friction
    model = SimpleNamespace(friction=SimpleNamespace(law=law), release_volume=1e4,
                            surface=SimpleNamespace(vertices=np.array([[0.0, 0.0, 1700.0], [9.0, 0.0, 2400.0]])))
    for kind, count in (("dem", 1), ("mesh", 0)):
        scene = SimpleNamespace(dimension=3, terrain=SimpleNamespace(kind=kind, friction=law))
        found = list(class_of_friction(SimpleNamespace(scene=scene, model=model)))
        assert len(found) == count
        assert all("no ground lies below 1700 m" in caution.says for caution in found)


def test_list_shows_classes_and_laws():
    done = CliRunner().invoke(app, ["list"])
    assert done.exit_code == 0
    for name in [*NUMBERS, *LAWS]:
        assert re.search(rf"^  {name} ", done.stdout, re.MULTILINE), name


def test_maps_and_reports_name_the_law():
    def run(friction):
        text = f"[terrain]\nfriction = {friction}\n"

        class OfMaps(SimpleNamespace):
            def __len__(self):
                return 0

        return parameters(OfMaps(provenance={"scene": text}, name="a", maps={}))["bed friction"]

    assert run("0.3") == "0.3"
    assert run('{ law = "voellmy", mu = 0.2, xi = 2000.0, tau0 = 0.0 }') == "voellmy mu = 0.2, xi = 2000"
    assert run('{ card = "ice", law = "coulomb", mu = { file = "mu.tif" } }') == "ice: coulomb"
