"""Scenes to start from: commented TOML files that run as they are."""

import json
import re
from pathlib import Path
from string import Template

from snowmpm.draft import draft
from snowmpm.errors import InputError
from snowmpm.scenes.loader import find_scene
from snowmpm.scenes.messages import shown

STARTS = Path(__file__).parent / "starts"
NAME = re.compile(r'^name\s*=\s*"[^"]*"', re.MULTILINE)
FILES = re.compile(r"""(?<![\w.])file\s*=\s*(?:"([^"]+)"|'([^']+)')""")
BESIDE = {".shp": (".dbf", ".shx", ".prj", ".cpg"), ".asc": (".prj",), ".obj": (".mtl",),
          ".tif": (".prj", ".tfw", ".tif.msk", ".tif.aux.xml")}
"""Files that belong to one of a kind, by their endings in place of its own."""


def start_from(template, **words):
    """Text of the template of this name, "profile" or "ground", with its placeholders filled; TOML values as they
    are."""
    text = (STARTS / f"{template}.toml").read_text(encoding="utf-8")
    return _aligned(Template(text).substitute(words))


def copy_of(scene, name, folder):
    """Text of a scene with its comments under another `name`; -> (text, files that it names, copied to `folder`).

    Raises InputError if a file of that name with other content exists there.
    """
    source = find_scene(scene)
    text, count = NAME.subn(f"name = {quoted(name)}", source.read_text(encoding="utf-8"), count=1)
    if not count:
        raise InputError(f"{source}: has no name to change")
    copied = []
    named = dict.fromkeys(double or single for double, single in FILES.findall(text))
    for file in dict.fromkeys(one for name in named for one in [name, *_beside(source.parent, name)]):
        there, here = source.parent / file, Path(folder) / file
        if Path(file).is_absolute() or not there.is_file():
            continue
        if ".." in Path(file).parts:
            raise InputError(f"{source}: file = {shown(file)}: lies above the scene's folder, and would be copied to"
                             f" above {folder}")
        if here.exists() and here.read_bytes() != there.read_bytes():
            raise InputError(f"{here}: there already, and not the file of {source.name}: choose another folder with -o")
        content = there.read_bytes()
        with draft(here) as part:
            part.write_bytes(content)
        copied.append(here)
    return text, copied


def _beside(folder, name):
    """Names of the files in a folder that belong to one of this name, whatever the case of their endings."""
    path = Path(name)
    if path.is_absolute() or ".." in path.parts or not (folder / path).parent.is_dir():
        return []
    wanted = {(path.stem + end).lower() for end in BESIDE.get(path.suffix.lower(), ())}
    return sorted(str(path.with_name(one.name)) for one in (folder / path).parent.iterdir()
                  if one.name.lower() in wanted and one.is_file())


def quoted(text):
    """Text as a TOML string."""
    return json.dumps(str(text), ensure_ascii=False)


def _aligned(text):
    """Align the comments behind short values in one column, as in the templates."""
    lines = []
    for line in text.split("\n"):
        value, mark, comment = line.partition("  # ")
        short = mark and not line.startswith("#") and len(value.rstrip()) < 33
        lines.append(f"{value.rstrip():<33} # {comment.lstrip()}" if short and value.strip() else line)
    return "\n".join(lines)
