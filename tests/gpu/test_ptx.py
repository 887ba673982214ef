"""Kernels compiled for CUDA without a card: `tests/benchmarks/ptx.py`, and what the document says of its table."""

import csv
import re
import shutil
import sys
from pathlib import Path

import pytest

from tests.benchmarks import ptx

ROOT = Path(__file__).parents[2]
ONE_THREAD = """
.visible .entry add_c1_0_kernel_1_range_for(
\t.param .align 8 .b8 add_param_0[32]
)                                       // -- Begin function
{
\t.reg .f32 \t%f<9>;
\tld.param.u64 \t%rd1, [add_param_0];
\tld.global.u64 \t%rd2, [%rd1];
\tld.f32 \t%f1, [%rd2+4];
\tfma.rn.ftz.f32 \t%f2, %f1, %f1, %f1;
\tcall.uni
\thelp$_1,
\t(
\tparam0
\t);
\t@%p1 atom.add.f32 \t%f3, [%rd2+8], %f2;
\tst.f64 \t[%rd2], %fd1;
}
.func help$_1(
\t.param .b64 help$_1_param_0
)
{
\tld.u64 \t%rd8, [%rd9];
\tmul.f64 \t%fd1, %fd1, %fd1;
\tatom.cas.b64 \t%rd4, [%rd5], %rd6, %rd7;
}
"""


def test_counts_of_a_kernel():
    ((name, body),) = ptx.ENTRY.findall(re.sub("//.*", "", ONE_THREAD))
    assert ptx.TASK.match(name).groups() == ("add", "1", "range_for")
    functions = dict(ptx.FUNCTION.findall(ONE_THREAD))
    assert list(functions) == ["help$_1"]
    found = ptx.counted(body, functions)
    assert {key: found[key] for key in ("flops", "double", "atomics", "exchanges", "pointers", "loaded", "stored")} == {
        "flops": 2, "double": 1, "atomics": 1, "exchanges": 1, "pointers": 2, "loaded": 4, "stored": 8}


def test_sums_to_memory_that_is_known():
    text = ptx.known_memory(ONE_THREAD)
    assert "atom.add" not in text and "add.u64 a, %rd2, 8;" in text and "red.global.add.f32 [a], %f2;" in text


@pytest.mark.parametrize(("registers", "warps"), [(20, 64), (64, 32), (149, 12), (244, 8), (255, 8)])
def test_warps_by_registers(registers, warps):
    """64 and 148 registers: 50 and 17 to 19 % of 64, as a card's counters said."""
    assert ptx.resident(registers, 128) == warps


@pytest.mark.skipif(shutil.which("cc") is None or sys.platform != "linux", reason="needs a C compiler, on Linux")
def test_the_step_is_compiled_for_cuda(tmp_path):
    """Each kernel of a step in 3-D: 27 nodes of 4 numbers a particle, hardly an operation in double precision."""
    texts, threads = ptx.texts_of("mpm", ptx.driver(tmp_path), tmp_path / "texts")
    found = {}
    for text in texts.values():
        bare = re.sub("//.*", "", text)
        functions = dict(ptx.FUNCTION.findall(bare))
        for name, body in ptx.ENTRY.findall(bare):
            task = ptx.TASK.match(name)
            if task and threads.get(name, 1) > 1:
                found[task[1], int(task[2])] = ptx.counted(body, functions)
    assert found["scatter_atomic", 3]["atomics"] == 27 * 4
    assert {key: counts["double"] for key, counts in found.items() if counts["double"] > 5} == {}
    assert found["gather_atomic", 3]["flops"] > 1000


@pytest.mark.slow
@pytest.mark.skipif(not ptx.tool("ptxas") or shutil.which("cc") is None, reason="needs ptxas and a C compiler")
def test_no_kernel_spills(tmp_path):
    libraries = ptx.driver(tmp_path)
    rows = [row for case in ptx.SOLVERS for row in ptx.rows_of(case, libraries, "sm_90", None)]
    assert len(rows) > 20 and {row["kernel"] for row in rows if row["spilled"]} == set()
    assert all(row["registers"] <= 255 for row in rows)


def test_the_document_shows_the_table():
    with ptx.TABLE.open(newline="", encoding="utf-8") as file:
        rows = {(row["case"], row["kernel"], row["loop"]): row for row in csv.DictReader(file)}
    assert {row["spilled"] for row in rows.values()} == {"0"}
    text = (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")
    lines = text[text.index("| case, kernel |"):].split("\n\n")[0].splitlines()
    heads = [cell.strip() for cell in lines[0].strip("|").split("|")]
    columns = {"registers": "registers", "warps of 64": "warps", "atomics": "atomics", "operations": "flops",
               "bytes read": "loaded", "bytes written": "stored", "machine instructions": "machine",
               "with known memory": "reductions"}
    for line in lines[2:]:
        cells = dict(zip(heads, (cell.strip(" `") for cell in line.strip("|").split("|")), strict=True))
        case, kernel, loop = re.fullmatch(r"(.+): `?(\w+)`? (\d)", cells.pop("case, kernel")).groups()
        assert cells == {head: rows[case, kernel, loop][columns[head]] for head in cells}, line
    assert len(lines) > 8
