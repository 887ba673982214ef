"""Lays out the pages of the documentation site: `python .ci/site_pages.py FOLDER`.

Pages keep their places in the repository, so that their links hold here and there. What they link to and show comes
with them. The pages of reference are made from the installed program (`snowmpm.cli.reference`).
"""

import base64
import json
import os
import re
import shutil
import sys
from pathlib import Path

from snowmpm.cli import reference
from snowmpm.cli.docs import PLACES, guides

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("docs", "scenes", "scenes/gallery", "materials")
SINGLE = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "tests/benchmarks/figures/stability.md")
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.DOTALL | re.MULTILINE)


def main():
    """Lay out all pages, and the files that they lead to, in the folder given, which is made anew."""
    out = Path(sys.argv[1]).resolve()
    shutil.rmtree(out, ignore_errors=True)
    pages = [ROOT / name for name in SINGLE]
    for folder in FOLDERS:
        pages += sorted((ROOT / folder).glob("*.md"))
    found = dict.fromkeys(pages)
    for page in pages:
        for target in LINK.findall(CODE.sub("", page.read_text(encoding="utf-8"))):
            path = Path(os.path.normpath(page.parent / target))
            if "://" not in target and path.is_file() and path.is_relative_to(ROOT):
                found[path] = None
    for path in found:
        place = out / path.relative_to(ROOT)
        place.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".md":
            place.write_text(_linked(path.read_text(encoding="utf-8"), place.parent, out), encoding="utf-8")
        else:
            shutil.copyfile(path, place)
    shutil.copyfile(ROOT / ".ci" / "site.css", out / "site.css")
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        _write_notebook(path, out / "docs" / "notebooks")
    for name in reference.PAGES:
        (out / "docs" / f"{name}.md").write_text(reference.page(name), encoding="utf-8")


def _linked(text, folder, out):
    """A page whose `snowmpm docs NAME` leads to the page of that name."""

    def link(match):
        name = match[1]
        if name not in guides():
            return match[0]
        return f"[{match[0]}]({os.path.relpath(out / PLACES.get(name, f'docs/{name}.md'), folder)})"

    text = re.sub(r"(\(notebooks/\w+)\.ipynb\)", r"\1.md)", text)
    return re.sub(r"(?<!\[)`snowmpm docs (\w+)`", link, text)


def _write_notebook(path, folder):
    """A notebook as a page with its pictures, and itself beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    parts = []
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
        for output in cell.get("outputs", ()):
            if picture := output.get("data", {}).get("image/png"):
                name = f"{path.stem}_{len(parts)}.png"
                (folder / name).write_bytes(base64.b64decode(picture))
                parts.append(f"![Result of the lines above]({name})")
            elif output["output_type"] == "stream" and not output["text"][0].startswith("[Taichi]"):
                parts.append(f"```text\n{''.join(output['text']).rstrip()}\n```")
    parts.append(f"This page is a notebook: [{path.name}]({path.name}).")
    (folder / f"{path.stem}.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    shutil.copyfile(path, folder / path.name)


if __name__ == "__main__":
    main()
