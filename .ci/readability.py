"""How long the sentences of README and guides are.

    python .ci/readability.py             each guide, and all
    python .ci/readability.py --at COMMIT the same of an earlier commit, for all only

A sentence ends with a full stop, a question mark, an exclamation mark or a colon, or with a paragraph or an item of a
list. Code, tables, pictures and headings do not count; a link counts by its words.
"""

import argparse
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("docs", "scenes", "materials", "render")
LONG = 30
"""Words above which a sentence is long."""


def sentences(text):
    """Sentences of a page, as lists of words."""
    text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    lines = [line for line in text.split("\n") if not re.match(r"\s*(\||#|\$\$|    )", line)]
    text = re.sub(r"\n\s*([-*]|\d+\.) ", "\n\n", "\n".join(lines))
    for paragraph in re.split(r"\n\s*\n", text):
        for one in re.split(r"(?<=[.?!:])[*)\"]*\s+(?=[A-Z`*(\[\"0-9])", " ".join(paragraph.split())):
            words = re.findall(r"[^\s]*\w[^\s]*", one)
            if len(words) > 1:
                yield words


def pages(commit=None):
    """{name: text} of README and guides."""
    if commit is None:
        paths = [ROOT / "README.md", *(path for folder in FOLDERS for path in sorted((ROOT / folder).glob("*.md")))]
        return {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in paths}
    names = _git("ls-tree", "-r", "--name-only", commit).split("\n")
    chosen = [name for name in names if name == "README.md" or re.fullmatch(rf"({'|'.join(FOLDERS)})/\w+\.md", name)]
    return {name: _git("show", f"{commit}:{name}") for name in chosen}


def _git(*words):
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout


def row(name, found):
    """A line of the table."""
    lengths = [len(words) for words in found]
    mean, share = sum(lengths) / max(1, len(lengths)), sum(n > LONG for n in lengths) / max(1, len(lengths))
    return f"{name:<34} {len(lengths):>9} {mean:>18.1f} {100 * share:>14.1f} {max(lengths, default=0):>8}"


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--at", metavar="COMMIT", help="all pages of an earlier commit")
    asked = words.parse_args()
    found = {name: list(sentences(text)) for name, text in pages(asked.at).items()}
    print(f"{'page':<34} {'sentences':>9} {'words per sentence':>18} {f'% above {LONG}':>14} {'longest':>8}")
    if not asked.at:
        for name, of_page in found.items():
            print(row(name, of_page))
    print(row("all", [one for of_page in found.values() for one in of_page]))


if __name__ == "__main__":
    main()
