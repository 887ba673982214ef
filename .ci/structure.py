"""How simple is the program to change? Sizes and counts of the sources beside what they must come to.

    python .ci/structure.py            prints the table
    python .ci/structure.py --where    and where each count comes from
    python .ci/structure.py --types    and mypy's errors, which takes a minute

Product: snowmpm, materials, scenes, render. Nothing is imported; the sources are parsed.
"""

import argparse
import ast
import io
import re
import subprocess
import sys
import tokenize
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("snowmpm", "materials", "scenes", "render")
MOST_ARGUMENTS = 8
TYPED = ("mpm", "sph", "depth", "implicit", "stepping", "particles", "components", "setup", "running", "handover")
"""Packages in which mypy looks into functions without annotations too."""

def sources():
    """{path from the root: its text} of the product, each file once."""
    found = {}
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            found.setdefault(path.resolve().relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8"))
    return found


def names():
    """{component: those that it builds on}."""
    tree = ast.parse((ROOT / "snowmpm" / "components" / "__init__.py").read_text(encoding="utf-8"))
    return next(ast.literal_eval(node.value) for node in tree.body
                if isinstance(node, ast.Assign) and node.targets[0].id == "NAMES")


def named_in(text, component):
    """Names and strings of a module's code that are the name of a component, or a path that begins with it."""
    found = []
    if component not in text:  # most files, of which each would be read for each component
        return found
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        words = token.string.strip("\"'")
        whole = token.type in (tokenize.NAME, tokenize.STRING) and words == component
        path = token.type == tokenize.STRING and re.search(rf"(^|[.:]){component}[.:][a-z0-9]", words)
        if whole or path:
            found.append(token.start[0])
    return found


def statements(tree):
    """Statements of a module, docstrings not among them."""
    return sum(isinstance(node, ast.stmt) and not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
               for node in ast.walk(tree))


def members(trees):
    """(methods and properties, attributes) of `stepping.contract.Method`."""
    body = next(node for node in trees["snowmpm/stepping/contract.py"].body
                if isinstance(node, ast.ClassDef) and node.name == "Method").body
    return ([node.name for node in body if isinstance(node, ast.FunctionDef)],
            [node.target.id for node in body if isinstance(node, ast.AnnAssign)])


def untyped_errors():
    """mypy's errors within functions without annotations."""
    packages = [word for name in TYPED for word in ("-p", f"snowmpm.{name}")]
    # Annotations of Taichi functions are calls, such as ti.template(), which mypy takes for no types
    options = ["--check-untyped-defs", "--config-file=", "--ignore-missing-imports", "--follow-imports=silent",
               "--disable-error-code=valid-type"]
    done = subprocess.run([sys.executable, "-m", "mypy", *options, *packages], cwd=ROOT, capture_output=True, text=True)
    found = re.search(r"Found (\d+) error", done.stdout)
    if not found and "Success" not in done.stdout:
        raise SystemExit(done.stdout + done.stderr)
    return int(found[1]) if found else 0


def measured():
    """Rows (what, how much, what it must be), the files that read by name, wide functions, members of Method."""
    texts = sources()
    trees = {path: ast.parse(text) for path, text in texts.items()}
    reads, wide = Counter(), []
    for path, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("getattr", "hasattr"):
                reads[path] += 1
            if isinstance(node, ast.FunctionDef):
                count = len([*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs])
                count -= bool(node.args.args) and node.args.args[0].arg in ("self", "cls")
                if count > MOST_ARGUMENTS:
                    wide.append((count, f"{path}: {node.name}"))
    functions, attributes = members(trees)
    rows = [("lines of the product", sum(text.count("\n") for text in texts.values()), "74000"),
            ("statements", sum(map(statements, trees.values())), "in proportion"),
            ("members of Method", f"{len(functions)} + {len(attributes)}", "about 10"),
            ("getattr, hasattr", sum(reads.values()), "40"),
            (f"functions of more than {MOST_ARGUMENTS} arguments", len(wide), "formulas and measured kernels")]
    components = names()
    for name in components:
        own = f"snowmpm/components/{name}/"
        above = {f"snowmpm/components/{other}/" for other, needed in components.items() if name in needed}
        outside = [path for path, text in texts.items()
                   if name in text and not path.startswith((own, *above)) and named_in(text, name)]
        rows.append((f"files that name {name}, a component", len(outside), "1"))
    return rows, reads, sorted(wide, reverse=True), [*functions, *attributes]


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--where", action="store_true", help="also where each count comes from")
    words.add_argument("--types", action="store_true", help="also mypy's errors")
    asked = words.parse_args()
    rows, reads, wide, of_method = measured()
    if asked.types:
        rows.append(("errors of mypy --check-untyped-defs", untyped_errors(), "0"))
    for name, value, target in rows:
        print(f"{name:<58} {value!s:>8}   must be {target}")
    if asked.where:
        print("\ngetattr and hasattr:", *(f"  {count} {path}" for path, count in reads.most_common()), sep="\n")
        print("\narguments:", *(f"  {count} {where}" for count, where in wide), sep="\n")
        print("\nMethod:", ", ".join(of_method))


if __name__ == "__main__":
    main()
