"""Generated C under analysers and sanitizers: no input crashes it, hangs it or makes it leave its arrays."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import modelgen.models as models
from modelgen.codegen import build
from modelgen.codegen.emit import templates_folder
from modelgen.codegen.function import Function

ROOT = Path(__file__).parents[1]
QUICK = ("kelvin_voigt", "modified_dahl")
EVERY = [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in models.SHIPPED]
ANALYSED = (*QUICK, "complex_stiffness")  # minutes for the others
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
needs_cppcheck = pytest.mark.skipif(shutil.which("cppcheck") is None, reason="cppcheck is not installed")

DRIVER = """
#include "{header}"
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static uint64_t state = 88172645463325252U;

static double drawn(void)
{{
    static const double nasty[] = {{
        0.0, -0.0, 1.0, -1.0, 5e-324, -5e-324, 1e-310, 1e308, -1e308, 1e-30, 1e30, INFINITY, -INFINITY, NAN
    }};
    state ^= state << 13U; state ^= state >> 7U; state ^= state << 17U;
    if (state % 3U == 0U) {{
        return nasty[(state >> 8U) % (sizeof nasty / sizeof nasty[0])];
    }}
    return ((double)(state >> 11U) / 9007199254740992.0 - 0.3) * 10.0;
}}

static double *room(const size_t count)
{{
    double *const a = malloc((count + (count == 0U)) * sizeof *a);
    for (size_t k = 0; k < count; ++k) {{
        a[k] = drawn();
    }}
    return a;
}}

int main(void)
{{
    static const double usual[] = {{ {usual} }};
    for (int round = 0; round < {rounds}; ++round) {{
        const size_t n = 1U + (size_t)(state % 40U);
        const size_t stride = {stride};
        const size_t nset = 1U + (size_t)(state % 3U);
        double *inputs[{inputs}];
        for (size_t k = 0; k < {inputs}; ++k) {{
            inputs[k] = room(n);
        }}
        const double *const *const in = (const double *const *)inputs;
        double *const p = room({parameters});
        for (size_t k = 0; k < {parameters}; ++k) {{
            p[k] = round % 2 == 0 && state % 4U != 0U ? usual[k] : p[k];
            (void)drawn();
        }}
        double *const theta = room(nset * {columns}), *const ssq = room(nset), *const normal = room({sums});
        double *const work = room({staged} * stride), *const data = room({channels} * stride);
        double *const weight = room({channels} * stride), *const all = room({rows} * n);
        double *const out = room({channels} * stride), *const jac = room({channels} * {columns} * stride);
{calls}
        for (size_t k = 0; k < {inputs}; ++k) {{
            free(inputs[k]);
        }}
        free(p); free(theta); free(ssq); free(normal); free(work); free(data); free(weight); free(out);
        free(jac); free(all);
    }}
    return 0;
}}
"""


def driver(function: Function, rounds: int) -> str:
    """A program that calls every kernel on what the sanitizers watch."""
    source, model = function.code.source, function.model
    columns, batch = len(function.wrt), not model.inputs
    calls = []
    for k in source.kernels:
        names = re.findall(r"(\w+)(?=[,)])", k.signature[k.signature.index("(") :])
        if k.name == "all":
            names = ["n" if x == "stride" else "all" if x == "out" else x for x in names]
        calls.append(f"        {source.prefix}_{k.name}({', '.join(names)});")
    values = [p.default or 1.0 for p in model.scalar_parameters]
    return DRIVER.format(
        header=f"{source.prefix}.h", usual=", ".join(map(repr, values)), rounds=rounds,
        stride="n" if batch else "(n + 15U) / 16U * 16U",
        inputs=len(values) if batch else len(model.inputs), parameters=len(values), columns=columns,
        sums=(columns + 1) * (columns + 2) // 2, staged=max(1, source.staged),
        channels=2 * len(source.outputs), rows=sum(1 + c for _, c in source.equations),
        calls="\n".join(calls),
    )  # fmt: skip


@needs_gcc
@pytest.mark.parametrize("name", EVERY)
def test_no_input_makes_it_crash_hang_or_write_out_of_bounds(name: str, tmp_path: Path) -> None:
    function = build(getattr(models, name))
    (tmp_path / "fuzz.c").write_text(driver(function, 100))
    guards = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"]
    command = ["gcc", "-std=c99", "-O0", "-g", *guards, f"-I{ROOT / 'generated'}", "fuzz.c"]
    command += [str(ROOT / "generated" / f"{name}.c"), "-o", "fuzz", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True, timeout=300)
    done = subprocess.run([tmp_path / "fuzz"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr[:2000]


@needs_gcc
@pytest.mark.parametrize("name", ANALYSED)
def test_the_analyser_finds_nothing(name: str) -> None:
    path = str(ROOT / "generated" / f"{name}.c")
    command = ["gcc", "-std=c99", "-O1", "-fanalyzer", "-Werror", "-c", path, "-o", "/dev/null"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[:2000]


@needs_cppcheck
@pytest.mark.slow
def test_every_deviation_from_misra_is_listed_with_its_reason(tmp_path: Path) -> None:
    table = (templates_folder() / "DEVIATIONS.md").read_text()
    listed = {r for row in re.findall(r"^\| (\d[^|]*) \|", table, re.MULTILINE) for r in row.split(", ")}
    for name in (f"{n}.{end}" for n in ANALYSED for end in "hc"):  # cppcheck leaves its notes beside them
        shutil.copy(ROOT / "generated" / name, tmp_path)
    sources = [str(tmp_path / f"{n}.c") for n in ANALYSED]
    command = [
        "cppcheck",
        "--std=c99",
        "--enable=warning,performance,portability",
        "--addon=misra",
        "--quiet",
    ]
    command += ["--suppress=missingIncludeSystem", "--template={id} {file}:{line}", *sources]
    found = subprocess.run(command, capture_output=True, text=True, timeout=300).stderr.splitlines()
    others = [line for line in found if not line.startswith("misra-c2012-")]
    assert not others, others[:5]
    rules = {line.split()[0].removeprefix("misra-c2012-") for line in found}
    assert rules <= listed and rules
