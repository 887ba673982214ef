"""Every key of the file of a region, as `keys` of a scene."""

from importlib import resources

from snowmpm.cli.reference.keys import blocks, keys_page

INTRODUCTION = """# Every key of a region

From the schema of the program, as [the keys of a scene](keys.md). [A whole region](region.md) says what they are for.
"""


def page():
    """Keys of a region as Markdown."""
    from snowmpm.region.spec import RegionFile

    guides = resources.files("snowmpm.guides")
    guide, example = ((guides / name).read_text(encoding="utf-8") for name in ("region.md", "region.toml"))
    return keys_page(RegionFile.model_json_schema(), INTRODUCTION, [example, *blocks(guide)])
