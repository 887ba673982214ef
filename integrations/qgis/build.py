"""Makes snowmpm_qgis.zip, which *Plugins > Manage and Install Plugins > Install from ZIP* of QGIS takes.

    python build.py [-o DIR]
    python build.py --texts de     writes or completes snowmpm_qgis/i18n/snowmpm_de.ts, for Qt's Linguist and lrelease

The help page is docs/qgis.md. Every translation that is there as .qm is packed.
"""

import argparse
import ast
import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree as xml

from markdown_it import MarkdownIt

HERE = Path(__file__).resolve().parent
PLUGIN, GUIDE = HERE / "snowmpm_qgis", HERE.parents[1] / "docs" / "qgis.md"
PACKED = ("*.py", "metadata.txt", "icon.svg", "LICENSE", "i18n/*.qm")
WORDS, TABLES = ("TITLE", "GROUP", "ABOUT"), ("NUMBERS", "MAPS", "SCORES", "RANGES")
"""Attributes that are texts, and tables whose second entries are."""
PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>snowmpm in QGIS</title><style>
body {{ font: 16px/1.5 sans-serif; max-width: 46em; margin: 2em auto; padding: 0 1em; color: #222 }}
table {{ border-collapse: collapse }} td, th {{ border-bottom: 1px solid #ccc; padding: .3em .8em; text-align: left }}
code, pre {{ background: #f3f3f3 }} pre {{ padding: .6em; overflow-x: auto }}
</style></head><body>{}</body></html>
"""


def help_page():
    """The guide as one page without pictures and links to other guides."""
    text = re.sub(r"\[([^\]]+)\]\((?!#|https?:)[^)]*\)", r"\1", GUIDE.read_text(encoding="utf-8"))
    lines = [line for line in text.splitlines() if not line.startswith("!")]
    page = MarkdownIt("commonmark").enable("table").render("\n".join(lines))
    return PAGE.format(re.sub(r"<h([23])>([^<]*)</h", lambda one: (
        f'<h{one[1]} id="{re.sub("[^a-z0-9]+", "-", one[2].lower())}">{one[2]}</h'), page))


def texts():
    """What the plugin says, in the order of its files: arguments of tr() and of self.add(), words of algorithms."""
    found = {}
    for path in sorted(PLUGIN.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                name = getattr(node.func, "id", getattr(node.func, "attr", ""))
                found.update(dict.fromkeys({"tr": node.args[:1], "add": node.args[1:2],
                                            "add_output": node.args}.get(name, [])))
            elif isinstance(node, ast.Assign):
                target = node.targets[0]
                pairs = zip(target.elts, node.value.elts) if isinstance(target, ast.Tuple) and isinstance(  # noqa: B905
                    node.value, ast.Tuple) else [(target, node.value)]
                for own, value in pairs:
                    if getattr(own, "id", "") in WORDS:
                        found[value] = None
                    elif getattr(own, "id", "") in TABLES:
                        found.update(dict.fromkeys(one.elts[1] for one in ast.walk(value)
                                                   if isinstance(one, ast.Tuple) and len(one.elts) > 1))
    nested = [inner for node in found for inner in ast.walk(node)]
    return list(dict.fromkeys(node.value for node in nested if isinstance(node, ast.Constant)
                              and isinstance(node.value, str) and node.value.strip()))


def write_texts(language):
    """Write the texts for translation, with the translations that are there; -> the path."""
    path = PLUGIN / "i18n" / f"snowmpm_{language}.ts"
    known = {one.findtext("source"): one.findtext("translation") for one in xml.parse(path).iter("message")
             } if path.exists() else {}
    root = xml.Element("TS", version="2.1", language=language, sourcelanguage="en")
    context = xml.SubElement(root, "context")
    xml.SubElement(context, "name").text = "snowmpm"
    for text in texts():
        message = xml.SubElement(context, "message")
        xml.SubElement(message, "source").text = text
        translation = xml.SubElement(message, "translation", **({} if known.get(text) else {"type": "unfinished"}))
        translation.text = known.get(text)
    xml.indent(root)
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"<!DOCTYPE TS>\n{xml.tostring(root, encoding='unicode')}\n", encoding="utf-8")
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path())
    parser.add_argument("--texts", metavar="LANGUAGE")
    chosen = parser.parse_args()
    if chosen.texts:
        print(write_texts(chosen.texts))
        return
    path = chosen.output / "snowmpm_qgis.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for pattern in PACKED:
            for source in sorted(PLUGIN.glob(pattern)):
                archive.write(source, f"snowmpm_qgis/{source.relative_to(PLUGIN).as_posix()}")
        archive.writestr("snowmpm_qgis/help.html", help_page())
    print(path)


if __name__ == "__main__":
    main()
