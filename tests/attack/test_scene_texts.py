"""Scenes, materials and settings as texts that nobody would write by hand: refused with a reason, never a fault."""

import pytest
from scenes_under_attack import BLOCK, block, written

DIGITS = "9" * 5000
LONG = "x" * 2_000_000

VALUES = {
    "digits": DIGITS, "negative_digits": f"-{DIGITS}", "hex_digits": "0x" + "f" * 5000, "long_float": f"1e{DIGITS}",
    "nested_lists": "[" * 3000 + "]" * 3000, "deeper_lists": "[" * 100_000,
    "nested_tables": "{a=" * 2000 + "1" + "}" * 2000,
    "long_text": f'"{LONG}"', "long_list": f"[{'1,' * 300_000}]", "nan": "nan", "inf": "-inf", "true": "true",
    "date": "2020-01-01", "time": "23:59:59.999999", "date_time": "1979-05-27T00:32:00.999999-07:00",
    "empty_text": '""', "empty_list": "[]", "empty_table": "{}", "list_of_tables": "[{}]", "mixed": '[1, "a", [true]]',
    "escape": '"\\u001b[31mred\\u0007"', "bidi": '"\\u202Eoverride"', "nul": '"\\u0000"', "dollar": '"$\\\\frac{"',
    "markup": '"[bold]x[/nothing]"', "html": '"<script>alert(1)</script>"', "percent": '"%s%n{0}{name}"',
    "tiny": "5e-324", "huge": "1e308", "big_int": str(2**63), "bigger_int": str(10**400), "minus_zero": "-0.0",
}
KEYS = ["name", "dimension", "end_time", "seed", "gravity", "solver.dx", "materials.snow.density",
        "materials.snow.kind", "bodies.0.material", "bodies.0.shape", "domain.max", "output.fields"]
KINDS = ("number", "text", "list")


def toml_with(key, value):
    """The text of a scene with one key of this value, written as text, so that nothing of ours has to write it."""
    *tables, last = key.split(".")
    lines, inside, found = [], [], False
    heads = {"": [], "[output]": ["output"], "[solver]": ["solver"], "[domain]": ["domain"],
             "[materials.snow]": ["materials", "snow"], "[[bodies]]": ["bodies", "0"]}
    for line in BLOCK.splitlines():
        inside = heads.get(line.strip(), inside) if line.startswith("[") else inside
        if inside == tables and line.startswith(f"{last} ="):
            line, found = f"{last} = {value}", True
        lines.append(line)
        if line.startswith("[") and inside == tables and not any(f"\n{last} =" in part for part in [BLOCK]):
            lines.append(f"{last} = {value}")
            found = True
    assert found, key
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("key", ["end_time", "name", "bodies.0.shape"])
@pytest.mark.parametrize("value", VALUES)
def test_value_in_the_file(withstood, tmp_path, key, value):
    written(tmp_path / "scene.toml", toml_with(key, VALUES[value]))
    withstood("check", "scene.toml", code=2)


@pytest.mark.parametrize("key", KEYS)
@pytest.mark.parametrize("value", ["digits", "deeper_lists", "long_list", "escape", "nested_tables"])
def test_value_on_the_command_line(withstood, tmp_path, key, value):
    block(tmp_path)
    text = VALUES[value]
    withstood("check", "scene.toml", "--set", f"{key}={text[:100_000]}", code=2)


@pytest.mark.parametrize("text", [
    "", "=", "=1", "a", ".=1", "..=1", "a..b=1", "bodies.0.=1", "bodies.-1.name=x",
    "bodies.99999999999999999999.name=x",
    "bodies.²=1", "bodies." + "9" * 5000 + "=1", "materials.snow.density." * 3000 + "=1", "a." * 100_000 + "b=1",
    "\x1b[2J=1", "name=\x1b]0;title\x07", "solver.dx=1\nend_time=2", "solver.dx=\"", "solver.dx='''", "solver=1",
    "solver.dx=" + "1" * 5000, "materials=[]", "bodies={}", "bodies.0=1", "materials.snow=1", "terrain=1", "events=1",
    "saw_test=1", "reference=1", "picture=1", "picture.times=[" + "1," * 50_000 + "]", "initial=[]", "domain=[[]]",
    "solver.sph=[]", "name=" + "a" * 100_000, "x" * 100_000 + "=1", "materials." + "y" * 100_000 + "={}",
    "gravity=[1,2,3,4]", "gravity={}", "seed=-1", "seed=1.5", "seed=1e3",
], ids=lambda text: repr(text[:24])[1:-1])
def test_setting(withstood, tmp_path, text):
    block(tmp_path)
    withstood("check", "scene.toml", "--set", text, code=2)


FILES = {
    "empty": b"", "nul": b"\0" * 1000, "utf16": BLOCK.encode("utf-16"), "latin1": b'name = "\xe9"\n',
    "bom": b"\xef\xbb\xbf" + BLOCK.encode(),
    "surrogate": b'name = "\xed\xa0\x80"', "carriage_returns": b"a = 1\r" * 100,
    "deep_keys": (".".join("a" * 50_000) + " = 1").encode(),
    "deep_header": ("[" + ".".join("a" * 50_000) + "]").encode(),
    "many_tables": b"".join(b"[t%d]\n" % i for i in range(30_000)),
    "many_materials": BLOCK.encode() + b"".join(
        b'[materials.m%d]\nkind = "elastic"\ndensity = 300.0\nyoungs_modulus = 1e5\npoisson_ratio = 0.2\n' % i
        for i in range(5_000)),
    "many_unknown": BLOCK.encode().replace(b"[output]", b"".join(
        b"k%d = 1\n" % i for i in range(10_000)) + b"[output]"),
    "5_mebibytes": b"#" * (5 << 20), "long_line": b"a" * (3 << 20), "comment": b"#" * (3 << 20),
    "twice": BLOCK.encode() + b"[solver]\ndx = 1\n", "array_of_nothing": b"bodies = [[[[]]]]\n",
    "long_polygon": BLOCK.encode().replace(b'kind = "box", min = [0.2, 0.0], max = [0.6, 0.4]',
                                           b'kind = "polygon", points = ["' + b"x" * 500_000 + b'"]'),
    "elf": b"\x7fELF" + b"\0" * 500, "gzip": b"\x1f\x8b" + b"\0" * 500,
    "sphere_of_nothing": BLOCK.encode().replace(b"[output]", b'[saw_test]\nslope_angle = "x"\n[output]'),
}


@pytest.mark.parametrize("name", FILES)
def test_file(withstood, tmp_path, name):
    written(tmp_path / "scene.toml", FILES[name])
    withstood("check", "scene.toml", code=(0, 2) if name in ("bom", "many_materials") else 2)


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize("argument", [
    "", " ", ".", "..", "/", "/dev/null", "/dev/zero", "/proc/self/mem", "~", "x" * 5000, "a\nb", "\x1b[31m.toml", "-",
    "\udcff\udcfe.toml", "http://localhost/x.toml", "scene.toml/", "[bold].toml", "\u202egnp.toml",
], ids=lambda text: repr(text[:16])[1:-1])
def test_scene_argument(withstood, command, argument):
    withstood(command, argument, code=2)


CARDS = {
    "list": "material = []", "number": "materials = 1", "nested": "material = " + "{a=" * 2000 + "1" + "}" * 2000,
    "no_kind": "[material]\ndensity = 1", "digits": f'[material]\nkind = "elastic"\ndensity = {DIGITS}',
    "kind_list": "[material]\nkind = []", "long_kind": f'[material]\nkind = "{LONG}"', "empty": "",
    "many": "".join(f"[materials.m{i}]\nkind = 1\n" for i in range(20_000)), "card_list": "[material]\ncard = []",
    "long_name": f"[materials.{LONG}]\nkind = 1", "control": '[materials."\\u001b[2J"]\nkind = 1\n[materials.b]\nx = 1',
}


@pytest.mark.parametrize("name", CARDS)
def test_material_file(withstood, tmp_path, name):
    written(tmp_path / "card.toml", CARDS[name])
    withstood("element", "oedometer", "-m", "card.toml", code=2)


@pytest.mark.parametrize("arguments", [
    ("oedometer", "-m", "x" * 100_000), ("x" * 100_000, "-m", "li_cold_dense"), ("oedometer", "-m", "kind=\x1b[2J"),
    ("oedometer", "-m", "kind=elastic", "--set", f"density={DIGITS}"), ("oedometer", "-m", "li_cold_dense:"),
    ("oedometer", "-m", ":"), ("oedometer", "-m", "card.toml:" + "x" * 100_000), ("oedometer", "-m", "slab_release:\n"),
    ("oedometer", "-m", "li_cold_dense", "--strain", "nan"), ("oedometer", "-m", "li_cold_dense", "--strain", "0"),
    ("oedometer", "-m", "li_cold_dense", "--pressure", "-1"), ("oedometer", "-m", "li_cold_dense", "--pressure", "inf"),
    ("oedometer", "-m", "li_cold_dense", "--rate", "0"), ("oedometer", "-m", "li_cold_dense", "--rate", "nan"),
    ("oedometer", "-m", "li_cold_dense", "--steps", "0"), ("oedometer", "-m", "li_cold_dense", "--steps", DIGITS),
    ("oedometer", "-m", "li_cold_dense", "--steps", "1" + "0" * 15),
    ("oedometer", "-m", "li_cold_dense", "--strain", "1e300"),
    ("oedometer", "-m", "li_cold_dense", "-o", "x" * 5000),
], ids=lambda arguments: repr(" ".join(arguments)[-28:])[1:-1])
def test_element_argument(withstood, arguments):
    withstood("element", *arguments, code=2)


@pytest.mark.parametrize("arguments", [
    ("info",), ("plot",), ("maps",), ("report",), ("render",), ("compare", "other"),
])
@pytest.mark.parametrize("run", ["", "/", "/dev/zero", "x" * 5000, "\x1b[2J", "a\nb\nc\nd", "\udcff", "[red]", "."],
                         ids=lambda text: repr(text[:8])[1:-1])
def test_run_argument(withstood, arguments, run):
    withstood(*arguments, run, code=2)


@pytest.mark.parametrize("arguments", [
    ("new", "x" * 5000), ("new", "../x"), ("new", "\x1b[2J"), ("new", "a", "--like", "x" * 5000),
    ("new", "a", "--like", "../../etc/passwd"), ("new", "a", "-o", "/dev/null"), ("new", "a", "-o", "x" * 5000),
    ("new", "a", "--terrain", "/dev/zero"), ("new", "a", "--terrain", "x" * 5000 + ".stl"),
    ("new", "a", "--terrain", "\udcff.stl"), ("new", "a", "--thickness", "nan"),
    ("gallery", "../x"), ("gallery", "x" * 5000), ("study", "x" * 5000), ("study", "stability", "--only", "x" * 5000),
    ("study", "stability", "--only", "\x1b[2J"), ("render", ".", "--size", "9" * 5000 + "x1"),
    ("render", ".", "--size", "1x1"),
    ("render", ".", "--size", "99999999x99999999"), ("render", ".", "--fps", "nan"),
    ("check", "slab_release_2d", "--set"), ("run", "slab_release_2d", "--threads", "9" * 5000),
    ("run", "slab_release_2d", "-o", "x" * 5000), ("run", "slab_release_2d", "-o", "/dev/null/x"),
    ("run", "slab_release_2d", "-o", "/proc/1/x"), ("\x1b[2J",), ("x" * 5000,), ("--" + "y" * 5000,),
], ids=lambda arguments: repr(" ".join(arguments)[:32])[1:-1])
def test_argument(withstood, arguments):
    withstood(*arguments, code=2)


@pytest.mark.slow
def test_thousands_of_bodies(withstood, tmp_path):
    """Told what they cost, or refused, in less than a minute of processor time."""
    shape = 'shape = { kind = "sphere", centre = [0.5, 0.5], radius = 0.1 }'
    written(tmp_path / "scene.toml", BLOCK + "".join(
        f'[[bodies]]\nname = "b{i}"\nmaterial = "snow"\n{shape}\n' for i in range(25_000)))
    withstood("check", "scene.toml", processor=60)
