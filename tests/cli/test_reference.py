"""Pages of reference say everything, and are made from the program."""

import re

import pytest

from snowmpm.cli.reference import PAGES, keys, page

CELLS = re.compile(r"(?<!\\)\|")


def rows(text):
    """(section, cells) of all tables of a page, without heads."""
    section = ""
    for line in text.splitlines():
        if line.startswith("#"):
            section = line
        elif line.startswith("| `"):
            yield section, [cell.strip() for cell in CELLS.split(line)[1:-1]]


@pytest.mark.parametrize("name", ["keys", "campaign_keys", "region_keys"])
def test_every_key_has_words_and_an_example(name):
    """But those that say which of several tables one is, and those that hold a table, which is linked."""
    bare = [(section, cells[0]) for section, cells in rows(page(name))
            if cells[0] not in ("`kind`", "`law`", "`distribution`")
            and (not cells[1] or not (cells[5] or "](#" in cells[4]))]
    assert bare == []


def test_every_number_of_a_scene_has_a_unit():
    from snowmpm.scenes.schema import Scene

    assert [place for place, unit in keys.units(Scene.model_json_schema()).items() if unit is None] == []


@pytest.mark.parametrize("name", ["keys", "campaign_keys", "region_keys"])
def test_every_key_of_the_schema_is_on_the_page(name):
    from snowmpm.campaigns.spec import CampaignFile
    from snowmpm.region.spec import RegionFile
    from snowmpm.scenes.keytree import places
    from snowmpm.scenes.schema import Scene

    schema = {"keys": Scene, "campaign_keys": CampaignFile, "region_keys": RegionFile}[name].model_json_schema()
    told = {cells[0].strip("`") for _, cells in rows(page(name))}
    assert set(places(schema)) - {"NAME", *keys.WRITTEN} <= told


@pytest.mark.parametrize("name", sorted(PAGES))
def test_links_of_a_page_lead_to_its_headings(name):
    from snowmpm.cli.reference.markdown import anchor

    text = page(name)
    headings = [anchor(line.lstrip("# ")) for line in text.splitlines() if line.startswith("#")]
    assert set(re.findall(r"\]\(#([^)]*)\)", text)) <= set(headings)
    linked = [one for one in re.findall(r"\]\(#([^)]*)\)", text)]
    assert all(headings.count(one) == 1 for one in linked)


def test_examples_by_hand_are_of_keys_that_there_are():
    """EXAMPLES of each table; one that a subclass does not have would be forgotten."""
    from snowmpm.campaigns import spec  # noqa: F401
    from snowmpm.keys import Keyed
    from snowmpm.scenes import schema  # noqa: F401

    waiting, found = [Keyed], 0
    while waiting:
        table = waiting.pop()
        waiting += table.__subclasses__()
        if "EXAMPLES" in vars(table) and hasattr(table, "model_fields"):
            aliases = {field.alias or key for key, field in table.model_fields.items()}
            assert vars(table)["EXAMPLES"].keys() <= aliases, table
            found += 1
    assert found > 30


def test_every_option_of_every_command_is_told():
    import typer

    from snowmpm.cli.app import app

    text = page("commands")
    for name, command in typer.main.get_command(app).commands.items():
        for inner, one in getattr(command, "commands", {"": command}).items():
            part = text.split(f"## {f'{name} {inner}'.strip()}\n")[1].split("\n## ")[0]
            options = [option for option in one.params if option.param_type_name == "option" and option.name != "help"]
            assert all(option.opts[0] in part for option in options if not option.hidden), name


def test_every_field_and_number_is_told():
    from snowmpm.particles.fields import field_units
    from snowmpm.quantities.table import QUANTITIES

    told = {cells[0].strip("`"): cells[2] for _, cells in rows(page("fields"))}
    assert {*field_units(), *QUANTITIES} <= set(told) and all(told[name] for name in told)


def test_every_public_name_is_told():
    import snowmpm

    text = page("api")
    assert all(f"### `snowmpm.{name}`" in text for name in snowmpm.__all__ if name != "Run")
    assert "### `snowmpm.io.Run`" in text and "#### `frame`" in text and "### `snowmpm.materials.WetSnow`" in text


def test_cards_name_their_sources():
    from snowmpm.scenes import friction_cards, material_cards

    text = page("cards")
    for name in (*material_cards(), *friction_cards()):
        assert f"### `{name}`" in text
    assert text.count("\nSource: ") == len(material_cards()) + len(friction_cards())
