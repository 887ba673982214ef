"""Who may import whom, and the house rules that a machine can check."""

import ast
import functools
import re
import subprocess
import sys
from pathlib import Path

import pytest

from snowmpm import components
from tests.support.project import PROJECT, ROOT

FOLDERS = {
    "snowmpm": "snowmpm",
    "snowmpm.materials": "materials",
    "snowmpm.scenes": "scenes",
    "snowmpm.render": "render",
    "snowmpm.guides": "docs",
}

# Layer -> layers it may import from, beside itself. A layer is a package; files of snowmpm/ itself are one each.
GROUND = {"annotations", "cores", "errors", "draft", "memory", "overwriting", "schemes", "stages", "glance",
          "amounts", "reading", "quantities", "methods", "registry", "plugins", "keys", "notebook"}
"""What everybody may use: it computes nothing and knows no layer."""
SHARED = {"compiler", "particles", "stepping"}
SCENE = {"scenes", "materials", "ground", "terrain", "seeding", "solids", "prescribed",
         "saw_test", "water"}
MAY_IMPORT = {
    **{key: set() for key in ("annotations", "cores", "errors", "home", "schemes", "stages", "glance", "amounts",
                              "quantities", "keys")},
    "registry": {"errors"},
    "notebook": {"stages"},
    "plugins": {"errors", "registry"},
    "methods": {"registry"},
    # Declarations and what builds a component from a scene; its adapters take a method's kernels
    "components": {*GROUND, *SHARED, *SCENE, "mpm", "sph", "depth", "implicit",
                   "running", "advice", "study"},
    "materials": {"compiler", "registry", "keys"},
    "memory": {"errors"},
    "overwriting": {"errors"},
    "draft": {"overwriting"},
    "reading": {"memory", "errors", "overwriting"},
    "ground": {*GROUND, "compiler", "materials", "terrain"},
    "scenes": {*GROUND, "components", "materials", "ground", "water", "events"},  # scenes of observed avalanches
    "io": GROUND,
    "measured": GROUND,
    "comparison": {*GROUND, "materials", "io"},
    "render": {*GROUND, "results", "io"},
    "compiler": {"cores", "errors", "home"},
    "particles": {*GROUND, "compiler", "materials"},  # the laws declare what a particle carries and reports
    "stepping": {*GROUND, "compiler", "particles"},
    "terrain": {*GROUND, "compiler"},
    "seeding": {*GROUND, "terrain"},
    "solids": {*GROUND, "compiler", "stepping", "seeding", "terrain"},
    "prescribed": GROUND,
    "water": {*GROUND, "compiler", "particles", "stepping", "materials"},
    "gis": {*GROUND, "io", "seeding", "terrain"},
    "events": {*GROUND, "scenes", "terrain", "gis", "io"},
    "saw_test": {*GROUND, "components", "compiler", "particles", "scenes", "materials"},
    "results": {*GROUND, "compiler", "particles"},
    "micro": {*GROUND, "compiler", "seeding", "materials"},  # the laws that tests of grains are fitted with
    "mpm": {*GROUND, *SHARED, "solids", "materials"},
    "sph": {*GROUND, *SHARED, "materials"},
    # MPM as well: the same splines and lines of contact
    "implicit": {*GROUND, *SHARED, "mpm", "materials"},
    "setup": {*GROUND, "components", *SHARED, *SCENE, "io", "results"},  # methods by name (`snowmpm.methods`)
    "handover": {*GROUND, *SHARED, *SCENE, "setup"},
    "running": {*GROUND, "components", *SHARED, *SCENE, "setup", "handover", "io", "measured", "results"},
    "study": {*GROUND, "components", *SHARED, *SCENE, "mpm", "sph", "depth", "setup", "running", "io", "measured",
              "render"},
    "advice": {*GROUND, "components", "particles", "stepping", "scenes", "saw_test", "setup", "handover", "running",
               "measured", "study"},
    "campaigns": {*GROUND, "compiler", "scenes", "seeding", "setup", "running", "io", "gis", "advice", "comparison",
                  "render", "events", "runout"},
    "strength": {*GROUND, "scenes", "materials", "setup", "running", "io", "comparison"},
    "runout": {*GROUND, "components", "compiler", "ground", "depth", "setup", "io", "gis"},
    "pit": {*GROUND, "scenes", "materials", "saw_test", "terrain", "setup", "io", "gis", "render", "campaigns"},
    "region": {*GROUND, "scenes", "terrain", "seeding", "setup", "io", "gis", "campaigns", "runout"},
    "ladder": {*GROUND, "components", "compiler", "stepping", "scenes", "saw_test", "setup", "handover", "running",
               "terrain", "io", "measured", "study", "advice", "comparison", "strength", "runout", "render"},
    "cli": {*GROUND, *SHARED, *SCENE, "setup", "running", "io", "gis", "comparison", "render", "measured", "study",
            "advice", "ladder", "campaigns", "micro", "strength", "events", "runout",
            "pit", "region"},
}
DOOR = "snowmpm.compiler.backend"
PICTURES = {"pyvista", "vtk", "vtkmodules", "matplotlib", "imageio", "PIL"}
FORBIDDEN = {
    "quantities": PICTURES | {"h5py", "scipy", "trimesh", "typer", "rich"},
    "materials": PICTURES | {"h5py", "trimesh", "typer", "rich"},
    "scenes": PICTURES | {"h5py", "trimesh", "typer", "rich"},
    "gis": PICTURES | {"h5py", "trimesh", "typer", "rich"},
    "io": PICTURES | {"trimesh", "typer", "rich"},
    "comparison": PICTURES | {"h5py", "trimesh", "typer", "rich"},
    "render": {"h5py", "typer"},
    "mpm": PICTURES | {"h5py", "typer", "rich"},
    "sph": PICTURES | {"h5py", "typer", "rich"},
    "implicit": PICTURES | {"h5py", "typer", "rich"},
    **dict.fromkeys(("compiler", "particles", "stepping", "results", "micro"),
                    PICTURES | {"h5py", "trimesh", "typer", "rich"}),
    **dict.fromkeys(("measured", "reading", "quantities"), PICTURES | {"h5py", "trimesh", "typer", "rich"}),
    "terrain": PICTURES | {"h5py", "typer", "rich"},
    "ground": PICTURES | {"h5py", "trimesh", "typer", "rich"},
    "seeding": PICTURES - {"PIL"} | {"h5py", "typer", "rich"},  # images of microstructures come in as .tif
    "solids": PICTURES - {"PIL"} | {"h5py", "typer", "rich"},  # pictures on meshes of obstacles
    "saw_test": PICTURES | {"h5py", "typer", "rich"},
}
# What a distribution is imported as, where the two names differ.
IMPORT_NAMES = {"vtk": "vtkmodules", "pyshp": "shapefile", "pillow": "PIL", "usd-core": "pxr",
                "markdown-it-py": "markdown_it"}


@functools.cache
def modules():
    """Every module of the sources: dotted name -> path."""
    found = {}
    for package, folder in FOLDERS.items():
        for path in (ROOT / folder).rglob("*.py"):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            found[".".join([package, *(part for part in parts if part != "__init__")])] = path
    return found


TOP = {"snowmpm", "snowmpm.__main__"}
"""The program itself: it names whom it starts."""


def layer(module):
    return module if module in TOP else module.split(".")[1]


@functools.cache
def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def imported(module):
    """Dotted names that a module imports, anywhere in it; of `from package import name`, the module it names."""
    path = modules()[module]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*parents, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                yield inner if inner in modules() else base


@pytest.mark.parametrize("module", sorted(modules()))
def test_layers(module):
    own = layer(module)
    allowed = MAY_IMPORT.get(own, set(MAY_IMPORT))
    for name in imported(module):
        top = name.split(".")[0]
        if top == "snowmpm":
            other = layer(name)
            # `from snowmpm import __version__` is a fact about the program, not a dependency on a layer.
            assert name == "snowmpm" or other == own or other in allowed, f"{module} ({own}) imports {name}"
        assert top not in FORBIDDEN.get(own, ()), f"{module} ({own}) imports {name}"
        assert top not in ("materials", "scenes", "render"), f"{module} imports {name}: the name is snowmpm.{name}"


def test_components_are_imported_by_name_only():
    """Nothing but a component itself, and those that build on it, imports one: `snowmpm.components` finds them."""
    def component(name):
        return name.split(".")[2] if name.startswith("snowmpm.components.") else ""

    def may(module, name):
        return component(name) in ("", "contract", component(module), *components.NAMES.get(component(module), ()))

    wrong = {f"{module} imports {name}" for module in modules() for name in imported(module)
             if not may(module, name) and not module.startswith("snowmpm.guides.")}  # programs of their own
    assert not wrong


def test_components_take_of_a_method_what_it_offers():
    """Its `kernel_api`, and nothing behind it; entries of the atlas compare methods with themselves."""
    behind = re.compile(r"snowmpm\.(mpm|sph|depth|implicit)\.(?!kernel_api$)")
    wrong = {f"{module} imports {name}" for module in modules() for name in imported(module)
             if module.startswith("snowmpm.components.") and "atlas" not in module and behind.match(name)}
    assert not wrong


def test_what_is_imported_is_declared():
    wanted = {name.split(".")[0] for module in modules() for name in imported(module)}
    extras = PROJECT["project"]["optional-dependencies"]
    declared = [*PROJECT["project"]["dependencies"], *(one for name in ("gis", "cluster", "xarray", "export",
                                                                             "peers") for one in extras[name])]
    names = {re.match(r"[A-Za-z0-9_.-]+", requirement)[0].lower() for requirement in declared}
    known = {IMPORT_NAMES.get(name, name).replace("-", "_") for name in names}
    # precice: of a guide's example, which who couples with preCICE has; IPython: of the notebook that it runs in
    others = {"tomllib", "snowmpm", "pydantic_core", "precice", "IPython"}
    assert wanted - set(sys.stdlib_module_names) - known - others == set()


def test_every_package_is_shipped():
    on_disk = {module for module, path in modules().items() if path.name == "__init__.py"}
    assert on_disk == set(PROJECT["tool"]["setuptools"]["packages"])
    without_init = {path.parent for path in modules().values() if not (path.parent / "__init__.py").exists()}
    assert not without_init


@pytest.mark.parametrize("folder", ["materials", "scenes", "render"])
def test_import_guard(folder):
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r}); import {folder}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert f"ImportError: import this package as snowmpm.{folder}" in done.stderr


def test_taichi_is_imported_only_where_it_computes():
    # In this order, one process shows which import would have brought it in.
    names = ["snowmpm", "snowmpm.errors", "snowmpm.cli.app", "snowmpm.io", "snowmpm.render"]
    code = "\n".join(f"import {name}, sys; assert 'taichi' not in sys.modules, {name!r}" for name in names)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


def test_importing_starts_nothing():
    names = [name for name in sorted(modules()) if name != "snowmpm.__main__"]
    imports = "\n".join(f"import {name}" for name in names)
    code = f"{imports}\nfrom taichi.lang import impl\nassert impl.get_runtime().prog is None"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("module", sorted(modules()))
def test_house_rules(module):
    path = modules()[module]
    nodes = list(ast.walk(tree(path)))
    calls = {ast.unparse(node.func) for node in nodes if isinstance(node, ast.Call)}
    if module != "snowmpm.compiler.runtime":
        assert not calls & {"ti.init", "taichi.init"}, "Taichi is started in snowmpm/compiler/runtime.py only"
    if DOOR in imported(module) or "snowmpm.compiler" in imported(module):
        # Taichi reads annotations of kernels as objects, and fails on text.
        assert "__future__.annotations" not in {
            f"{n.module}.{a.name}" for n in nodes if isinstance(n, ast.ImportFrom) for a in n.names
        }
    assert ast.get_docstring(tree(path)), "every module says what it is"
    assert not {"utils", "helpers", "manager", "misc"} & set(path.relative_to(ROOT).with_suffix("").parts)


def test_one_module_imports_the_compiler_of_kernels():
    """All others take `ti` from `snowmpm.compiler`; only that folder names what is inside it."""
    outer = {module: {name.split(".")[0] for name in imported(module)} for module in modules()}
    assert {module for module, names in outer.items() if names & {"taichi", "quadrants", "taichi_forge"}} == {DOOR}
    by_name = re.compile(r"import_module\((chosen|.*(taichi|quadrants))")
    assert {module for module, path in modules().items() if by_name.search(path.read_text(encoding="utf-8"))} == {DOOR}
    outside = {module for module, path in modules().items() if layer(module) != "compiler"
               and (re.search(r"\bti\.(lang|_lib|_kernels)\b|\bimpl\.", path.read_text(encoding="utf-8"))
                    or DOOR in imported(module))}
    assert not outside


def test_no_absolute_path_and_no_machine():
    suffixes = {".py", ".toml", ".md", ".cfg", ".yml", ".csv"}
    tracked = [p for p in ROOT.rglob("*") if p.suffix in suffixes or p.name == "run"]
    skipped = {".git", ".venv", "build", "dist", "runs", "__pycache__", ".pytest_cache", ".ruff_cache", ".mypy_cache",
               ".hypothesis"}
    pattern = re.compile(r"""(?<![\w./~-])/(work|home|tmp|root|Users|opt|mnt)/""")
    for path in tracked:
        if path.is_file() and not skipped & set(path.relative_to(ROOT).parts) and path != Path(__file__).resolve():
            found = pattern.search(path.read_text(encoding="utf-8", errors="replace"))
            assert not found, f"{path.relative_to(ROOT)} names {found[0]}"


def test_tests_share_through_support_alone():
    """No test takes anything from another test or a conftest: what two of them need is in `tests/support`."""
    wrong = []
    for path in (ROOT / "tests").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Import | ast.ImportFrom):
                continue
            names = [getattr(node, "module", None) or "", *(alias.name for alias in node.names)]
            last = {name.split(".")[-1] for name in names}
            wrong += [f"{path.relative_to(ROOT)}: {name}" for name in last
                      if name == "conftest" or name.startswith("test_")]
    assert not wrong


def test_test_modules_can_be_told_apart():
    """pytest takes modules of folders without `__init__.py` for one module when they have one name."""
    names = {}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        package, top = path.parent, path.stem
        while (package / "__init__.py").exists():
            package, top = package.parent, f"{package.name}.{top}"
        names.setdefault(top, []).append(path.relative_to(ROOT).as_posix())
    assert not {name: paths for name, paths in names.items() if len(paths) > 1}
