"""Makes snowmpm_qgis.zip, which *Plugins > Manage and Install Plugins > Install from ZIP* of QGIS takes.

    python build.py [-o DIR]

The help page is docs/qgis.md. Texts for translation: pylupdate5 snowmpm_qgis/*.py -ts snowmpm_qgis/i18n/snowmpm_de.ts,
then lrelease; every .qm in i18n is packed.
"""

import argparse
import re
import zipfile
from pathlib import Path

from markdown_it import MarkdownIt

HERE = Path(__file__).resolve().parent
PLUGIN, GUIDE = HERE / "snowmpm_qgis", HERE.parents[1] / "docs" / "qgis.md"
PACKED = ("*.py", "metadata.txt", "icon.svg", "LICENSE", "i18n/*.qm")
PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>snowmpm in QGIS</title><style>
body {{ font: 16px/1.5 sans-serif; max-width: 46em; margin: 2em auto; padding: 0 1em; color: #222 }}
table {{ border-collapse: collapse }} td, th {{ border-bottom: 1px solid #ccc; padding: .3em .8em; text-align: left }}
code, pre {{ background: #f3f3f3 }} pre {{ padding: .6em; overflow-x: auto }}
</style></head><body>{}</body></html>
"""


def help_page():
    """The guide as one page without pictures."""
    text = re.sub(r"\[([^\]]+)\]\((?!#|https?:)[^)]*\)", r"\1", GUIDE.read_text(encoding="utf-8"))
    lines = [line for line in text.splitlines() if not line.startswith("!")]
    page = MarkdownIt("commonmark").enable("table").render("\n".join(lines))
    return PAGE.format(re.sub(r"<h([23])>([^<]*)</h", lambda one: (
        f'<h{one[1]} id="{re.sub("[^a-z0-9]+", "-", one[2].lower())}">{one[2]}</h'), page))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path())
    path = parser.parse_args().output / "snowmpm_qgis.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for pattern in PACKED:
            for source in sorted(PLUGIN.glob(pattern)):
                archive.write(source, f"snowmpm_qgis/{source.relative_to(PLUGIN).as_posix()}")
        archive.writestr("snowmpm_qgis/help.html", help_page())
    print(path)


if __name__ == "__main__":
    main()
