"""Material cards: numbers of the sources, use by name in scenes, and what a user reads when a name is wrong."""

import re

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.materials import LAWS
from snowmpm.scenes import Scene, load_scene, material_card, material_cards
from snowmpm.scenes.cards import FOLDER
from snowmpm.scenes.material_source import load_material

# Numbers as the sources print them, in the order of the columns.
LI = "kind density youngs_modulus poisson_ratio critical_slope cohesion hardening p0"
SAND = "kind density youngs_modulus poisson_ratio friction_angle dilation_angle cohesion"
NUMBERS = {
    # Li et al. (2021), table 1: E = 3 MPa, nu = 0.3, density 250 (V: 200); M, beta, xi, p0
    "li_cold_dense": (LI, "cohesive_cam_clay", 250, 3e6, 0.3, 0.5, 0, 1, 3e3),
    "li_warm_shear": (LI, "cohesive_cam_clay", 250, 3e6, 0.3, 1.5, 0.3, 1, 30e3),
    "li_sliding_slab": (LI, "cohesive_cam_clay", 250, 3e6, 0.3, 1.5, 0.5, 1, 42e3),
    "li_warm_plug": (LI, "cohesive_cam_clay", 250, 3e6, 0.3, 0.5, 1, 0.1, 12e3),
    "li_vallee_de_la_sionne": (LI, "cohesive_cam_clay", 200, 3e6, 0.3, 0.7, 0.2, 0.002, 3e3),
    # reference set W3 of the weak layer
    "gaume_weak_layer": (LI + " softening", "anticrack_cam_clay", 100, 0.5e6, 0.3, 1, 0.3, 0.5, 1.8e3, 0.5),
    # Stomakhin et al. (2013), table 2
    "stomakhin": (
        "kind density youngs_modulus poisson_ratio hardening critical_compression critical_stretch",
        *("stomakhin_snow", 4e2, 1.4e5, 0.2, 10, 2.5e-2, 7.5e-3),
    ),
    # Fávero Neto and Borja (2018), sections 4.1 and 4.3, table 3 (whose modulus differs from that of the text of 4.1)
    "lube_sand": (SAND, "drucker_prager", 1850, 20.16e6, 0.3, 37, 0, 0),
    "toyoura_sand": (SAND, "drucker_prager", 1379, 21.6e6, 0.3, 35, 0, 0),
    # Bui et al. (2008)
    "aluminium_bars": (SAND, "drucker_prager", 2650, 0.84e6, 0.3, 19.8, 0, 0),
    # Peng et al. (2015), table 1; its c = 5 kPa is the apex
    "peng_sand": (SAND + " reference_pressure", "hypoplastic", 1850, 20e6, 0.2, 30, 1, 0, 100e3),
    "peng_slope": (SAND, "hypoplastic", 1850, 30e6, 0.2, 30, 0, 5e3 * np.tan(np.radians(30.0))),
    # Wu, Wang and Alipour (2020), table 1: A (negative there), m1, m2
    "wu_fast_sand": ("kind collision_time constant_share square_share friction_angle poisson_ratio", "solid_to_gas",
                     0.0008, 0.5, 0.001, 30, 0),
    # Yamanoi and Endo (2002), by SNOWPACK, at 350 kg/m3; modulus: Bergfeld et al. (2023), by WEAC
    "yamanoi_melt_forms": (SAND + " water_weakening", "wet_snow", 350, 9.38e7, 0.25, 30, 0, 1.258e4, 23.5),
    # Bui and Nguyen (2021), table 2; eta_c = 5
    "bui_sensitive_clay": ("kind density youngs_modulus poisson_ratio friction_angle cohesion residual_cohesion"
                           " softening_strain", "softening_cone", 2150, 25e6, 0.49, 0, 25e3, 1.5e3, 0.2),
    # Jop, Forterre and Pouliquen (2006); Dunatunga and Kamrin (2015)
    "jop_beads": ("kind density youngs_modulus poisson_ratio static_friction limit_friction inertial_number "
                  "grain_diameter grain_density", "mu_i", 1500, 1e9, 0.3, 0.3819, 0.6435, 0.279, 0.53e-3, 2450),
    # Larese et al. (2020), table 2
    "larese_soil": (SAND, "mohr_coulomb", 2650, 0.84e6, 0.3, 19.8, 0, 0),
    # Chen and Abousleiman (2013): the derived numbers are in a test below
    "chen_clay": ("kind poisson_ratio critical_slope p0", "modified_cam_clay", 0.278, 1.2, 169e3),
    # Simo (1992), section 7.2
    "wilkins_copper": ("kind density youngs_modulus poisson_ratio yield_stress hardening_modulus",
                       "von_mises", 8930, 117e9, 0.35, 400e6, 100e6),
    # Schweizer et al. (2004), van Herwijnen et al. (2016), Sigrist (2006): the derived numbers are in a test below
    "schweizer_slab": ("kind density youngs_modulus poisson_ratio strength fracture_energy shear_ratio friction_angle",
                       "cohesive_crack", 200, 2.58e6, 0.25, 5.84e3, 0.137, 1, 30),
    "ice": ("kind density youngs_modulus poisson_ratio", "elastic", 917, 9.2e9, 0.328),
}


def scene(material="li_cold_dense", **more):
    body = {"name": "block", "material": material, "shape": {"kind": "box", "min": [0, 0], "max": [1, 1]}}
    return {"name": "card", "dimension": 2, "end_time": 1.0, "solver": {"dx": 0.1}, "bodies": [body], **more}


SCENE = """
name = "card"
dimension = 2
end_time = 1.0
solver = { dx = 0.1 }
%s
[[bodies]]
name = "block"
material = "%s"
shape = { kind = "box", min = [0.0, 0.0], max = [1.0, 1.0] }
"""


@pytest.fixture
def written(tmp_path):
    """Writes a scene file with a body of this material, and these lines of [materials]."""

    def write(material, lines=""):
        path = tmp_path / "scene.toml"
        path.write_text(SCENE % (lines, material), encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_are_those_of_the_source(name):
    keys, *values = NUMBERS[name]
    law = material_card(name)
    assert type(law) is LAWS[values[0]]
    for key, value in zip(keys.split()[1:], values[1:], strict=True):
        assert getattr(law, key) == pytest.approx(value, rel=2e-8), key  # eight digits are given
    assert law.card == name


def test_every_card_is_in_the_table_and_says_what_it_is():
    cards = material_cards()
    assert set(cards) == set(NUMBERS) == {path.stem for path in FOLDER.glob("*.toml")}
    for card in cards.values():
        assert 20 < len(card.description) < 100 and "\n" not in card.description
        assert re.search(r"doi:10\.\d{4,}/\S+", card.source)
        assert len(card.validity) > 40
        assert card.material.wave_speed() > 0.0


def test_derived_numbers_of_the_sources():
    assert material_card("aluminium_bars").bulk_modulus == pytest.approx(0.7e6, rel=1e-12)
    assert material_card("toyoura_sand").youngs_modulus / 1379.0 == pytest.approx(125.0**2, rel=3e-3)  # its c0
    slope = material_card("peng_slope")
    assert slope.tensile_apex == pytest.approx(5e3, rel=2e-8)
    np.testing.assert_allclose(slope.coefficients, (-83.3, -264.9, -781.3, -255.2), atol=0.051)  # table 1
    np.testing.assert_allclose(material_card("peng_sand").coefficients, (-55.6, -171.2, -540.9, -170.9), atol=0.051)


def test_beads_and_clay_follow_the_numbers_of_their_sources():
    beads = material_card("jop_beads")
    angles = np.degrees(np.arctan([beads.static_friction, beads.limit_friction]))
    assert angles == pytest.approx([20.9, 32.76], abs=0.005)
    # Chen and Abousleiman: M, lambda, kappa, nu, critical specific volume, overconsolidation; p, q at rest [kPa]
    M, compression, swelling, nu, critical, over, p, q = 1.2, 0.15, 0.03, 0.278, 2.74, 1.2, 120.0, 60.0
    consolidated = over * p * (1.0 + (q / p) ** 2 / M**2)
    volume = critical + (compression - swelling) * np.log(2.0 / consolidated) - swelling * np.log(p)
    modulus = 3.0 * (1.0 - 2.0 * nu) * volume * p / swelling  # 3 (1 - 2 nu) K, kPa
    clay = material_card("chen_clay")
    assert clay.p0 == pytest.approx(1e3 * consolidated, rel=1e-3)
    assert clay.youngs_modulus == pytest.approx(1e3 * modulus, rel=1e-3)
    assert clay.shear_modulus == pytest.approx(4.302e6, rel=1e-3)  # as printed
    assert clay.hardening_law == "exponential"
    assert clay.hardening == pytest.approx(volume / (compression - swelling), rel=1e-3)


def test_wet_snow_follows_the_formulas_of_its_sources():
    card = material_card("yamanoi_melt_forms")
    assert card.cohesion == pytest.approx(4.97e-4 * card.density**2.91, rel=1e-3)
    assert card.water_weakening == pytest.approx(0.235 * 100.0)
    assert card.youngs_modulus == pytest.approx(6.5e9 * (card.density / 917.0) ** 4.4, rel=1e-3)
    wet = card.cohesion * card.strength_share(np.array([0.0, 0.05]))
    assert wet == pytest.approx([1.258e4, 3.885e3], rel=1e-3)


def test_a_slab_that_cracks_follows_the_formulas_of_its_sources():
    card = material_card("schweizer_slab")
    share = card.density / 917.0
    assert card.youngs_modulus == pytest.approx(0.93 * card.density**2.8, rel=1e-3)
    assert card.strength == pytest.approx(240e3 * share**2.44, rel=1e-3)
    toughness = 350.0 * share**1.9 / np.sqrt(1e-3)
    released = toughness**2 * (1.0 - card.poisson_ratio**2) / card.youngs_modulus
    assert card.fracture_energy == pytest.approx(released, rel=5e-3)  # of numbers rounded to three digits
    limits = [card.model_copy(update=changed).largest_length
              for changed in ({}, {"shear_ratio": 0.5}, {"strength": 2.5e3})]
    assert limits == pytest.approx([8.3e-3, 25e-3, 45e-3], rel=0.01)  # as its text says


def test_ice_is_the_average_of_its_crystals():
    # Gammon et al. (1983), -16 degrees, in 1e8 Pa; Hill's mean of Voigt's and Reuss' averages
    c11, c12, c13, c33, c44 = 139.29, 70.82, 57.65, 150.10, 30.14
    C = np.diag([c11, c11, c33, c44, c44, 0.5 * (c11 - c12)])
    C[0, 1] = C[1, 0] = c12
    C[0, 2] = C[2, 0] = C[1, 2] = C[2, 1] = c13
    S = np.linalg.inv(C)

    def parts(M):
        return np.trace(M[:3, :3]), M[0, 1] + M[1, 2] + M[0, 2], np.trace(M[3:, 3:])

    axial, mixed, shear = parts(C)
    K_voigt, G_voigt = (axial + 2.0 * mixed) / 9.0, (axial - mixed + 3.0 * shear) / 15.0
    axial, mixed, shear = parts(S)
    K_reuss, G_reuss = 1.0 / (axial + 2.0 * mixed), 15.0 / (4.0 * axial - 4.0 * mixed + 3.0 * shear)
    ice = material_card("ice")
    assert ice.bulk_modulus == pytest.approx(
        0.5e8 * (K_voigt + K_reuss), rel=5e-3
    )  # of numbers rounded to three digits
    assert ice.shear_modulus == pytest.approx(0.5e8 * (G_voigt + G_reuss), rel=5e-3)


@pytest.mark.parametrize("name", NUMBERS)
def test_a_body_names_a_card(name, written):
    loaded = load_scene(written(name))
    assert loaded.materials == {name: material_card(name)}


def test_resolved_scene_holds_numbers_and_provenance(written, tmp_path):
    loaded = load_scene(written("slab", '[materials.slab]\ncard = "li_warm_shear"\np0 = 2.0e4'))
    text = loaded.to_toml()
    for line in ('began_with = "li_warm_shear"', 'kind = "cohesive_cam_clay"', "p0 = 20000.0", "critical_slope = 1.5"):
        assert line in text
    resolved = tmp_path / "resolved.toml"
    resolved.write_text(text, encoding="utf-8")
    again = load_scene(resolved)
    assert again.model_dump() == loaded.model_dump() and again.to_toml() == text
    law = loaded.materials["slab"]
    assert law.p0 == 2e4 and (law.card, law.began_with) == (None, "li_warm_shear")
    assert law.model_dump(exclude={"p0", "card", "began_with"}) == material_card("li_warm_shear").model_dump(
        exclude={"p0", "card", "began_with"})


def test_numbers_of_a_resolved_scene_win_over_a_card_that_changed(written):
    given = material_card("ice").model_dump(exclude_none=True)
    numbers = "\n".join(f"{key} = {value!r}" for key, value in given.items())
    numbers = numbers.replace("'", '"').replace("917.0", "900.0")
    law = load_scene(written("ice", f"[materials.ice]\n{numbers}")).materials["ice"]
    assert (law.card, law.began_with, law.density) == (None, "ice", 900.0)


def test_overrides_of_a_card(written):
    loaded = load_scene(written("stomakhin"), {"materials.stomakhin.hardening": 5.0})
    assert loaded.materials["stomakhin"].hardening == 5.0
    assert loaded.materials["stomakhin"].youngs_modulus == 1.4e5
    changed = load_scene(written("stomakhin"), {"bodies.0.material": "ice"})
    assert list(changed.materials) == ["ice"]


def test_another_kind_takes_the_numbers_over(written):
    lines = '[materials.ice]\ncard = "ice"\nkind = "drucker_prager"\nfriction_angle = 30.0\ncohesion = 1e6'
    law = load_scene(written("ice", lines)).materials["ice"]
    assert (law.kind, law.youngs_modulus, law.cohesion) == ("drucker_prager", 9.2e9, 1e6)


def test_a_material_of_the_scene_wins_over_a_card(written):
    lines = '[materials.ice]\nkind = "elastic"\ndensity = 1.0\nyoungs_modulus = 1.0\npoisson_ratio = 0.0'
    law = load_scene(written("ice", lines)).materials["ice"]
    assert (law.density, law.card) == (1.0, None)


OWN = """
description = "My weak layer"
source = "Field book 7, page 12"

[material]
kind = "elastic"
density = 130.0
youngs_modulus = 4.0e5
poisson_ratio = 0.25
"""


@pytest.mark.parametrize("card", ["mine.toml", "mine", "{folder}/mine.toml"])
def test_a_card_of_ones_own_beside_the_scene(written, tmp_path, card):
    """Like `element -m mine.toml`; the resolved scene keeps where the numbers are from and needs the file no more."""
    own = tmp_path / "mine.toml"
    own.write_text(OWN)
    path = written("snow", f'[materials.snow]\ncard = "{card.format(folder=tmp_path)}"\ndensity = 140.0')
    loaded = load_scene(path)
    law = loaded.materials["snow"]
    assert (law.kind, law.youngs_modulus, law.density, law.card_source) == ("elastic", 4e5, 140.0,
                                                                          "Field book 7, page 12")
    text, elsewhere = loaded.to_toml(), tmp_path / "run"
    elsewhere.mkdir()
    (elsewhere / "scene.toml").write_text(text)
    own.unlink()
    assert load_scene(elsewhere / "scene.toml").to_toml() == text and "Field book 7" in text
    with pytest.raises(InputError, match="no such material card"):
        load_scene(path)


def test_a_body_names_a_card_of_ones_own(written, tmp_path):
    (tmp_path / "mine.toml").write_text(OWN.replace('source = "Field book 7, page 12"', ""))
    assert load_scene(written("mine")).materials["mine"].card_source == "file mine.toml, which names no source"
    (tmp_path / "mine.toml").write_text("name = 'no card'")
    assert "must be one of the materials" in message(written("mine"))


@pytest.mark.parametrize(("old", "new", "said"), [
    ("4.0e5", "-4.0e5", "mine.toml: material.youngs_modulus = -400000.0"),
    ("elastic", "elastik", "mine.toml: material.kind"), ("[material]", "[metarial]", "mine.toml"),
    ('kind = "elastic"', 'card = "other.toml"', "no such material card"), ("[material]", "[material", "not valid TOML"),
])
def test_errors_of_a_card_of_ones_own_name_its_file(written, tmp_path, old, new, said):
    (tmp_path / "mine.toml").write_text(OWN.replace(old, new))
    assert said in message(written("snow", '[materials.snow]\ncard = "mine.toml"'))


def test_a_card_of_ones_own_begins_with_one_of_the_library(written, tmp_path):
    (tmp_path / "mine.toml").write_text('[material]\ncard = "li_warm_shear"\np0 = 2e4')
    law = load_scene(written("snow", '[materials.snow]\ncard = "mine"')).materials["snow"]
    assert (law.p0, law.card) == (2e4, "mine")
    assert law.critical_slope == material_card("li_warm_shear").critical_slope
    assert load_material(str(tmp_path / "mine.toml"))[1].p0 == 2e4


def test_cards_in_python():
    data = scene()
    assert Scene.model_validate(data).materials["li_cold_dense"].p0 == 3e3
    assert "materials" not in data  # what was given stays
    assert load_material("li_cold_dense", {"p0": 1e4})[1].p0 == 1e4
    assert load_material("ice") == ("ice", material_card("ice"))


def message(path, changes=None):
    with pytest.raises(InputError) as caught:
        load_scene(path, changes)
    return str(caught.value)


def test_unknown_card_gets_near_matches(written):
    path = written("slab", '[materials.slab]\ncard = "li_cold_dens"')
    expected = 'materials.slab.card = "li_cold_dens": no such material card: did you mean li_cold_dense?'
    assert message(path) == f"{path}: {expected}"
    path = written("slab", '[materials.slab]\ncard = "granite"')
    assert message(path).endswith("no such material card: `snowmpm list` names them")
    path = written("li_cold_dens")
    expected = (
        'bodies.0.material = "li_cold_dens": must be one of the materials: none; or a material card: did you mean '
        "li_cold_dense?"
    )
    assert message(path) == f"{path}: {expected}"
    with pytest.raises(InputError, match='no material card "ices": did you mean ice'):
        material_card("ices")
    with pytest.raises(InputError, match="did you mean li_cold_dense"):
        load_material("li_cold_dens")


def test_messages_beside_a_card_name_their_key(written):
    path = written("slab", '[materials.slab]\ncard = "li_cold_dense"\np0 = -1.0')
    assert message(path) == f"{path}: materials.slab.p0 = -1.0: must be >= 0"
    path = written("slab", '[materials.slab]\ncard = "li_cold_dense"\nfriction_angle = 30.0')
    assert "materials.slab.friction_angle = 30.0: unknown key" in message(path)
    path = written("slab", "[materials.slab]\ncard = 3")
    assert "materials.slab" in message(path)
