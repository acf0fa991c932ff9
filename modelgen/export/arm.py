"""Cross-compiles for Cortex-M, runs in QEMU, and reads off what a unit costs there."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from modelgen.errors import ToolError

GCC, QEMU, SIZE = "arm-none-eabi-gcc", "qemu-system-arm", "arm-none-eabi-size"
TICK = 40
"""Instructions a tick of the boards' 25 MHz clock where an instruction takes 1 ns of the emulator's time."""
LIMIT = 120.0


@dataclass(frozen=True)
class Core:
    """A processor, and QEMU's board with it."""

    name: str
    machine: str
    flags: tuple[str, ...]


CORES = (
    Core("Cortex-M4F", "mps2-an386", ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")),
    Core("Cortex-M7", "mps2-an500", ("-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16")),
)
OPTIMISE = ("-std=c99", "-O2", "-ffunction-sections", "-fdata-sections")


@dataclass(frozen=True)
class Cost:
    """Most instructions of a call, at default parameters and at any; stack [bytes]; with the math library."""

    usual: int
    most: int
    stack: int


@dataclass(frozen=True)
class Footprint:
    """What a unit takes on one core: code of its own and with the math functions, static RAM, structs, frames
    of its own functions [bytes], `costs` by function, and the emulator's self-test output. Of the fitter, if
    there is one: all flash, its workspace [bytes], instructions for a sample in each run of the samples (0:
    too many to count)."""

    core: str
    own_flash: int
    flash: int
    static_ram: int
    parameters: int
    state: int
    frame: int
    costs: Mapping[str, Cost] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    passed: bool = False
    fit_flash: int = 0
    fit_workspace: int = 0
    fit_cost: int = 0


def missing_tools() -> tuple[str, ...]:
    """Which of the cross compiler and the emulator are not installed."""
    return tuple(tool for tool in (GCC, SIZE, QEMU) if shutil.which(tool) is None)


def versions() -> tuple[str, str]:
    """First lines of what compiler and emulator say of themselves."""
    lines = [_run([tool, "--version"], Path()).splitlines()[0] for tool in (GCC, QEMU)]
    return re.sub(r"^.*\) ", "", lines[0]).strip(), re.sub(r"\s*\(.*", "", lines[1]).split()[-1]


def measure(core: Core, prefix: str, files: Mapping[str, str]) -> Footprint:
    """Compile `files` (C texts by name, with startup.c, board.ld and measure.c), run, and read the results.

    Raises ToolError when a tool refuses, or the emulated program does not end in time.
    """
    with tempfile.TemporaryDirectory(prefix="modelgen-arm-") as name:
        folder = Path(name)
        left_out = f"{prefix}_test.c"  # measure.c includes it
        program = link(core, files, folder, left_out)
        own, data, bss = _sections(folder, f"{prefix}.o")
        frames = [int(line.split("\t")[1]) for line in (folder / f"{prefix}.su").read_text().splitlines()]
        whole = _linked(core, folder, [f"{prefix}.o"], _functions(folder, f"{prefix}.o"))
        fitter = [f"{prefix}_fit.o", "modelgen_fit.o", f"{prefix}.o"] if f"{prefix}_fit.c" in files else []
        fit_flash = _linked(core, folder, fitter, [f"{prefix}_fit"]) if fitter else 0
        text, passed = emulate(core, program)
    found = re.finditer(r"cost (\w+) (\d+) (\d+) (\d+)", text)
    costs = {m[1]: Cost(int(m[2]), int(m[3]), int(m[4])) for m in found}
    sizes = re.search(r"sizes (\d+) (\d+)", text)
    if sizes is None:
        raise ToolError(f"{QEMU} ({core.machine}) gave no result: {text.strip()[:200]}")
    fit = re.search(r"^fit (\d+) (\d+)$", text, re.M)
    return Footprint(
        core.name, own, whole, data + bss, int(sizes[1]), int(sizes[2]), max(frames), costs,
        worst_errors(text), passed, fit_flash, *((int(fit[2]), int(fit[1])) if fit else ()),
    )  # fmt: skip


def _linked(core: Core, folder: Path, objects: Sequence[str], functions: Sequence[str]) -> int:
    """Flash [bytes] of functions with all that they call."""
    entry = [f"-Wl,-u,{s}" for s in functions]
    alone = ["-nostartfiles", "--specs=nosys.specs", "-Wl,--gc-sections", "-Wl,-e,0", "-lm", "-w"]
    _run([GCC, *core.flags, *entry, *objects, *alone, "-o", "alone.elf"], folder)
    return _sections(folder, "alone.elf")[0]


def link(core: Core, files: Mapping[str, str], folder: Path, left_out: str = "") -> Path:
    """A program for the emulated board from C texts by name, startup.c and board.ld among them."""
    for file, text in files.items():
        (folder / file).write_text(text)
    sources = sorted(f for f in files if f.endswith(".c") and f != left_out)
    _run([GCC, *core.flags, *OPTIMISE, "-fstack-usage", "-c", *sources], folder)
    objects = [f.removesuffix(".c") + ".o" for f in sources]
    options = ["-nostartfiles", "--specs=rdimon.specs", "-T", "board.ld", "-Wl,--gc-sections", "-lm", "-w"]
    _run([GCC, *core.flags, *objects, *options, "-o", "program.elf"], folder)
    return folder / "program.elf"


def emulate(core: Core, program: Path) -> tuple[str, bool]:
    """What a program prints in the emulator, and whether it returned 0; instructions take 1 ns each."""
    command = [
        QEMU, "-M", core.machine, "-nographic", "-monitor", "none", "-serial", "none", "-icount", "shift=0",
        "-semihosting-config", "enable=on,target=native", "-kernel", str(program),
    ]  # fmt: skip
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=LIMIT, check=False, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        raise ToolError(f"{QEMU} ({core.machine}) did not end within {LIMIT:g} s") from None
    return done.stdout + done.stderr, done.returncode == 0


def worst_errors(text: str) -> dict[str, float]:
    """Worst relative error by output, from what a self-test prints."""
    return {m[1]: float(m[2]) for m in re.finditer(r"^\w+ (\w+) worst_error (\S+)$", text, re.M)}


def _functions(folder: Path, name: str) -> list[str]:
    listing = _run(["arm-none-eabi-nm", "--defined-only", "-g", name], folder)
    return [line.split()[-1] for line in listing.splitlines() if " T " in line]


def _sections(folder: Path, name: str) -> tuple[int, int, int]:
    """Code and constants, initialised data, zeroed data [bytes]."""
    text, data, bss = _run([SIZE, name], folder).splitlines()[1].split()[:3]
    return int(text), int(data), int(bss)


def _run(command: Sequence[str], folder: Path) -> str:
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, check=False, timeout=LIMIT,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as why:
        raise ToolError(f"{command[0]} failed: {why}") from why
    if done.returncode != 0:
        first = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr.strip()[:200])
        raise ToolError(f"{command[0]} refused the exported C: {first}")
    return done.stdout
