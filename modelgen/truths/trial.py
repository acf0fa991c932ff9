"""Concealed cases, each diagnosed in a process of its own that sees the case's folder alone, then scored.

python -m modelgen.truths.trial --n 40 --seed 1 [--kind single] [--domain force] [--noise coloured] [--jobs 2]
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from .drawing import draw
from .scoring import score
from .secret import DOMAINS, KINDS, NOISES, NOISES_OF, NotDetectable, seal, unseal
from .tables import report
from .write import write_case


def main(argv: Sequence[str] | None = None) -> int:
    """Run a trial and print its tables. Exit status 1 where a diagnosis failed to give a verdict."""
    args = _parser().parse_args(argv)
    with tempfile.TemporaryDirectory() as scratch:
        root = Path(args.keep or scratch)
        root.mkdir(parents=True, exist_ok=True)
        with ThreadPoolExecutor(args.jobs) as pool:
            rows = list(pool.map(lambda i: _one(args, i, root), range(args.n)))
    if args.json:
        Path(args.json).write_text(json.dumps(rows, indent=1), encoding="utf-8")
    print(report(rows))
    return int(any(r["error"] for r in rows))


def _parser() -> argparse.ArgumentParser:
    p = argparse.ArgumentParser(
        prog="modelgen.truths.trial", description=__doc__.split("\n")[0] if __doc__ else ""
    )
    p.add_argument("--n", type=int, default=40, help="number of cases")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--kind", choices=KINDS)
    p.add_argument("--domain", choices=DOMAINS)
    p.add_argument("--effect", help="one id, or two joined by +")
    p.add_argument("--noise", choices=[*NOISES, "all"], default="white", help="all: each kind in turn")
    p.add_argument("--d2", nargs=2, type=float, default=(30.0, 1e4), metavar=("LOW", "HIGH"))
    p.add_argument("--jobs", type=int, default=2)
    p.add_argument(
        "--command", default="modelgen diagnose", help="run as: COMMAND case.toml --json verdict.json"
    )
    p.add_argument("--timeout", type=float, default=300.0, help="seconds for a case")
    p.add_argument("--keep", help="write the cases into this folder and leave them there")
    p.add_argument("--json", help="write what each case gave into this file")
    return p


def _one(args: argparse.Namespace, i: int, root: Path) -> dict[str, Any]:
    """Draw, seal, write, diagnose, unseal and score one case."""
    seed = args.seed * 100_000 + i
    allowed = NOISES_OF[args.domain] if args.domain else NOISES
    noise = allowed[i % len(allowed)] if args.noise == "all" else args.noise
    effect = tuple(args.effect.split("+")) if args.effect and "+" in args.effect else args.effect
    row: dict[str, Any] = {"case": i, "seed": seed, "noise": noise, "error": ""}
    try:
        secret = draw(seed, args.kind, args.domain, effect, tuple(args.d2), noise)
    except NotDetectable as hidden:
        return row | {"error": f"not drawn: {hidden}"}
    text, digest = seal(secret)
    case = write_case(secret, root / f"case_{i:04d}")
    begun = time.perf_counter()
    verdict, error = _diagnose(args, case)
    row |= {"sha256": digest, "wall": time.perf_counter() - begun, "error": error, "folder": str(case.parent)}
    secret = unseal(text, digest)
    row |= {
        "domain": secret.domain,
        "kind": secret.kind,
        "effects": list(secret.effects),
        "variant": secret.variant,
        "d2": dict(secret.d2),
        "bent": max((abs(v) for v in secret.bent.values()), default=0.0),
    }
    return row | (score(secret, verdict) if verdict else {})


def _diagnose(args: argparse.Namespace, case: Path) -> tuple[dict[str, Any], str]:
    """The verdict on a case, or {} and why there is none."""
    out = case.parent / "verdict.json"
    out.unlink(missing_ok=True)
    command = [*shlex.split(args.command), case.name, "--json", out.name]
    env = {**os.environ, "OMP_NUM_THREADS": os.environ.get("OMP_NUM_THREADS", "1")}
    try:
        done = subprocess.run(
            command, cwd=case.parent, env=env, capture_output=True, text=True, timeout=args.timeout
        )
        if done.returncode:
            return {}, f"exit {done.returncode}: {(done.stderr.strip().splitlines() or [''])[-1][:200]}"
        verdict: dict[str, Any] = json.loads(out.read_text(encoding="utf-8"))
        return verdict, ""
    except subprocess.TimeoutExpired:
        return {}, f"no verdict within {args.timeout:g} s"
    except (OSError, json.JSONDecodeError) as error:
        return {}, f"no verdict: {error}"


if __name__ == "__main__":
    sys.exit(main())
