"""The commands. Each imports what it needs when it runs, so that `--help` is instant."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from modelgen.cli.once import App

app = App(
    help="Write physics once; get fast C with exact derivatives, fits, and the physics that was left out.",
    add_completion=False,
    rich_markup_mode=None,  # plain help: the framed one takes as long again
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

CasePath = Annotated[Path, typer.Argument(metavar="CASE.toml", help="the case: model, recordings, constants")]
Json = Annotated[Path | None, typer.Option("--json", help="write the result as JSON")]
Dask = Annotated[str, typer.Option(metavar="ADDRESS", help="run on the Dask cluster whose scheduler this is")]
Seed = Annotated[int, typer.Option(min=0, help="of all random numbers")]
MODEL = "a model that ships, or path/to/file.py:NAME"


@app.callback(invoke_without_command=True)
def start(version: Annotated[bool, typer.Option("--version", help="show the version")] = False) -> None:
    if version:
        from modelgen import __version__

        print(f"modelgen {__version__}")


@app.command()
def build(
    models: Annotated[list[str] | None, typer.Argument(metavar="[MODEL]...", help=f"{MODEL}; all")] = None,
    out: Annotated[Path, typer.Option(help="folder for the C")] = Path("generated"),
) -> None:
    """Generate C and compile it. Unchanged models change no byte."""
    from modelgen.cli.building import build_models

    build_models(models or [], out)


@app.command()
def fit(
    case: CasePath,
    json: Json = None,
    plot: Annotated[
        Path | None, typer.Option(help="draw recordings, model and residual: .svg, .png or .pdf")
    ] = None,
    method: Annotated[
        str | None,
        typer.Option(
            help="'gauss-newton', 'pso(40)', 'ipopt', 'ipopt(shooting=20)', 'multistart(20)', a chain "
            "'pso >> ipopt', or 'gmm-1', 'gmm-2', 'gmm-3': Methods 1 to 3 of the GMM paper (with its swarm: "
            "'gmm-3-paper'), or 'mre-stages': stages 2 to 4 of the MRE paper"
        ),
    ] = None,
    start: Annotated[list[str] | None, typer.Option(help="NAME=VALUE, where to begin")] = None,
    seed: Seed = 0,
    constrained: Annotated[
        bool, typer.Option("--constrained", help="keep the model's conditions, such as passivity")
    ] = False,
    dask: Dask = "",
) -> None:
    """Fit the model's free parameters to the recordings. Ctrl-C keeps the best so far.

    CASE may be a folder: each case in it is fitted, and the JSON holds them all.
    """
    if case.is_dir():
        from modelgen.cli.folders import fit_folder

        return fit_folder(
            case, json, method, seed, dask, {"--plot": plot, "--start": start, "--constrained": constrained}
        )
    from modelgen.cli.fitting import fit_case

    fit_case(case, json, plot, method, start or [], seed, constrained, dask)


@app.command()
def diagnose(
    case: CasePath,
    json: Json = None,
    report: Annotated[Path | None, typer.Option(help="write one self-contained HTML page")] = None,
    effects: Annotated[str, typer.Option(help="Python file with effects of your own")] = "",
    out: Annotated[Path, typer.Option(help="folder for the extended model and its C")] = Path("diagnosis"),
    seed: Seed = 0,
    dask: Dask = "",
) -> None:
    """Find the physics that the model leaves out.

    CASE may be a folder: each case in it is diagnosed, and the JSON holds them all.
    """
    if case.is_dir() or dask:
        from modelgen.cli.folders import diagnose_folder

        return diagnose_folder(case, json, report, effects, out, seed, dask)
    from modelgen.cli.diagnosing import diagnose_case

    diagnose_case(case, json, report, effects, out, seed)


@app.command()
def prove(
    trials: Annotated[int, typer.Option(help="concealed cases")] = 100,
    seed: Seed = 1,
    jobs: Annotated[int, typer.Option(help="cases at a time; by default as many as there are cores")] = 0,
    html: Annotated[Path | None, typer.Option(help="write one self-contained HTML page")] = None,
    json: Json = None,
    markdown: Annotated[Path | None, typer.Option(help="write the scores as Markdown")] = None,
    secret: Annotated[Path | None, typer.Option(help="a secret of your own instead of drawn ones")] = None,
    noise: Annotated[str, typer.Option(help="kinds of noise, with commas; all")] = "",
    domain: Annotated[str, typer.Option(help="impedance, gmm, force, stiffness, with commas; all")] = "",
    keep: Annotated[Path, typer.Option(help="folder for trials, digests and missed cases")] = Path("proof"),
    real: Annotated[Path | None, typer.Option(help="folder of measured cases")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="12 trials, no measured recordings")] = False,
    limit: Annotated[float, typer.Option(help="seconds for one diagnosis")] = 300.0,
) -> None:
    """Diagnose concealed cases, reveal them, and score. Ctrl-C loses nothing: the same command goes on."""
    from modelgen.cli.proving import prove_command

    raise typer.Exit(
        prove_command(
            trials, seed, jobs, html, json, markdown, secret, noise, domain, keep, real, quick, limit
        )
    )


@app.command()
def export(
    models: Annotated[list[str], typer.Argument(metavar="MODEL...", help=MODEL)],
    target: Annotated[str, typer.Option(help="what to write: c99 or fmu")] = "c99",
    out: Annotated[Path | None, typer.Option(help="folder, by default export/MODEL")] = None,
    real: Annotated[str, typer.Option(help="precision of the C: double or float")] = "double",
    name: Annotated[str, typer.Option(help="prefix of the C's names, by default the model's")] = "",
    fix: Annotated[list[str] | None, typer.Option(help="NAME=VALUE, a number instead of a parameter")] = None,
    fit: Annotated[
        Path | None, typer.Option(help="result of `modelgen fit --json`: its values are the defaults")
    ] = None,
    inverse: Annotated[bool, typer.Option("--inverse", help="also from output to input")] = False,
    fitter: Annotated[
        bool, typer.Option("--fitter", help="also C that fits the parameters on the controller")
    ] = False,
    range: Annotated[list[str] | None, typer.Option(help="NAME=LOW:HIGH, where inputs are tested")] = None,
) -> None:
    """Write models for use elsewhere, such as in a controller: C, self-test, and a measured datasheet."""
    from modelgen.cli.building import export_models
    from modelgen.export.c99 import Settings

    settings = Settings(real, name, fix or [], range or [], fitter=fitter)
    export_models(models, target, out, settings, inverse, fit)


@app.command()
def modal(
    frf: Annotated[
        Path, typer.Argument(metavar="FRF.csv", help="f [Hz] and responses: Re H, Im H or |H|, phase H")
    ],
    json: Json = None,
    low: Annotated[float, typer.Option("--from", help="lowest frequency that is used [Hz]")] = 0.0,
    high: Annotated[float, typer.Option("--to", help="highest [Hz]")] = float("inf"),
    modes: Annotated[
        int | None, typer.Option(help="keep so many, the strongest; by default all that are stable")
    ] = None,
    mass: Annotated[
        float | None, typer.Option(help="say the viscous damping 2ξMω of this mass, too [kg]")
    ] = None,
) -> None:
    """Natural frequencies and damping ratios, with uncertainties, from measured frequency responses."""
    from modelgen.cli.modal import modal_case

    modal_case(frf, json, low, high, modes, mass)


@app.command()
def loops(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING.csv", help="t [s], z [mm], F [N]")],
    json: Json = None,
    plot: Annotated[
        Path | None, typer.Option(help="draw loops, or k_s and loss angle of a sweep: .svg, .png or .pdf")
    ] = None,
    skip: Annotated[int, typer.Option(help="leave out so many cycles at the beginning")] = 0,
    length: Annotated[float | None, typer.Option(help="of the sample [mm]: say the strain, too")] = None,
    area: Annotated[float | None, typer.Option(help="its cross-section [mm²]: say the stress, too")] = None,
    against: Annotated[
        Path | None, typer.Option(help="an earlier recording of the same motion: say how the force shifted")
    ] = None,
) -> None:
    """Stiffness, damping and hysteresis of each cycle of a force-displacement recording, also of a sweep."""
    from modelgen.cli.loops import loops_case

    loops_case(recording, against, json, plot, skip, length, area)


@app.command()
def reproduce(
    paper: Annotated[list[str] | None, typer.Argument(metavar="[PAPER]...", help="gmm, mre; both")] = None,
    json: Json = None,
    html: Annotated[Path | None, typer.Option(help="write one self-contained HTML page")] = None,
) -> None:
    """Compute every published number of the papers behind the models anew, and say what became of it.

    About a minute. Ctrl-C keeps, prints and writes what is done.
    """
    from modelgen.cli.reproducing import reproduce_papers

    raise typer.Exit(reproduce_papers(paper or [], json, html))


@app.command("list")
def show() -> None:
    """List the models that ship and the effects that a diagnosis tries."""
    from modelgen.cli.listing import show_all

    show_all()
