"""The diagnosing process: it reads the path of a case from its pipe, and writes the verdict into its folder.

It is started before any secret is drawn, and all that ever reaches it are lines with the path of a case.toml
in a folder that holds nothing else but the recordings. It stays alive from case to case, since to start
Python and load what a diagnosis needs takes as long as a diagnosis; what it keeps are compiled kernels of
models. So that nothing of a case is left for the next, each is a fresh `diagnose(case, model)` as the command
`modelgen diagnose` makes it. It says which files it read besides the folder's, so that one needn't believe
that there were none.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from modelgen.errors import InputError, ToolError
from modelgen.prove.records import write_records
from modelgen.prove.watch import Watch

VERDICT = "verdict.json"
RESIDUALS = "residuals.npz"


def main() -> int:
    """Answer each line with one line of JSON: what went wrong or "", the seconds of processor time, and the
    files that were read outside the case's folder."""
    answer, sys.stdout = sys.stdout, sys.stderr  # what the diagnosis prints is no answer
    watch = Watch()
    for line in sys.stdin:
        case, begun = Path(line.rstrip("\n")), sum(os.times()[:4])  # with the compiler's
        with watch.on(case.parent) as foreign:
            error = diagnosed(case)
        told = {"error": error, "cpu": sum(os.times()[:4]) - begun, "foreign": sorted(foreign)}
        print(json.dumps(told), file=answer, flush=True)
    return 0


def diagnosed(path: Path) -> str:
    """Diagnose a case; write verdict and residuals beside it. Returns what went wrong, or ""."""
    from modelgen.api import open_case
    from modelgen.diagnose import diagnose

    try:
        model, case = open_case(path)
        verdict = diagnose(case, model, out=path.parent / "diagnosis")
        verdict.write_json(path.parent / VERDICT)
        write_records(path.parent / RESIDUALS, verdict.traces)
    except (InputError, ToolError) as error:
        return str(error)
    except Exception as error:  # a defect is a failed trial, not the end of the proof
        return f"{type(error).__name__}: {error}"
    return ""


if __name__ == "__main__":
    sys.exit(main())
