"""Every key of a campaign file, as `keys` of a scene."""

from importlib import resources

from snowmpm.cli.reference.keys import blocks, keys_page

INTRODUCTION = """# Every key of a campaign

From the schema of the program, as [the keys of a scene](keys.md). [Campaigns](campaigns.md) says what they are for.
"""


def page():
    """Keys of a campaign as Markdown."""
    from snowmpm.campaigns.spec import CampaignFile

    library = resources.files("snowmpm.scenes") / "library" / "campaigns"
    guide = (resources.files("snowmpm.guides") / "campaigns.md").read_text(encoding="utf-8")
    files = [path.read_text(encoding="utf-8") for path in sorted(library.iterdir(), key=lambda path: path.name)]
    return keys_page(CampaignFile.model_json_schema(), INTRODUCTION, [*files, *blocks(guide)])
