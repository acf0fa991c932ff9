"""A page says what the verdict says, needs nothing from outside, trusts no name; figures read as physics."""

import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from io import StringIO

import numpy as np
import pytest
import verdicts
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from modelgen.diagnose.verdict import Finding, Mismatch, PortCurve, Trial
from modelgen.errors import InputError
from modelgen.models import load
from modelgen.report import print_verdict, words, write_html
from modelgen.report.axes import fold, plain
from modelgen.report.curve import slope_and_phase, slope_text
from modelgen.report.formula import formula, sentence, symbol
from modelgen.report.html import page
from modelgen.report.thin import excerpt, extremes

VOID = {"meta", "br", "hr", "img", "input", "link"}


class Page(HTMLParser):
    """Elements, attributes and visible text; `wrong` lists what is not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str, str | None]] = []
        self.open: list[str] = []
        self.wrong: list[str] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data: str) -> None:
        if not {"style", "title"} & set(self.open):
            self.words.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", "".join(self.words))


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    return {name: page(make()) for name, make in verdicts.ALL.items()}


@pytest.mark.parametrize("name", verdicts.ALL)
def test_well_formed_and_self_contained(pages, name) -> None:
    seen = Page(pages[name])
    assert not seen.wrong and not seen.open
    assert not {"script", "link", "img", "iframe", "object"} & set(seen.tags)
    for tag, attribute, value in seen.attributes:
        assert not attribute.startswith("on")
        if attribute in ("href", "xlink:href", "src"):
            assert value and value.startswith("#"), (tag, value)
    assert not re.search(r"url\((?!#)|@import", pages[name])
    ids = [value for _, attribute, value in seen.attributes if attribute == "id"]
    assert len(ids) == len(set(ids))
    used = set(re.findall(r'(?:url\(#|href="#)([\w-]+)', pages[name]))
    assert used <= set(ids)
    assert len(pages[name].encode()) < 1_500_000


@pytest.mark.parametrize("name", verdicts.ALL)
def test_every_figure_is_described(pages, name) -> None:
    seen = Page(pages[name])
    labels = [value for tag, attribute, value in seen.attributes if (tag, attribute) == ("svg", "aria-label")]
    assert len(labels) == seen.tags.count("svg") == seen.tags.count("figcaption") == seen.tags.count("figure")
    assert all(labels)


def test_no_stand_in_colour_is_left(pages) -> None:
    text = "".join(pages.values())
    assert not re.search(r"#0102[0-9a-f]{2}", text)
    named = set(re.findall(r"var\(--(\w+)\)", text))
    assert {"data", "before", "after", "band", "shade", "mark"} <= named
    dark = text[text.index("prefers-color-scheme: dark") :].split("} }")[0]
    assert all(f"--{name}:" in dark for name in named)


def test_says_the_verdict(pages) -> None:
    text = Page(pages["several"]).text
    for part in (
        "Left out: semi inductance", "93 %", "12.4 → 1.01", "9.80 → 1.03", "eddy shunt", "Next experiment:",
        "held out", "Wright, JAES 38 (1990) 749", "0.03004 ± 0.00012", "White, relative to |Z|", "3 outliers",
    ):  # fmt: skip
        assert part in text, part
    assert "Slope 0.50, phase 45°: the mark of diffusion" in text
    fine = Page(pages["adequate"]).text
    assert "Nothing is missing" in fine and "before" not in fine
    assert "that no catalogued effect describes" in Page(pages["unknown"]).text


def test_parameters_that_were_bent_are_told_from_those_that_were_not(pages) -> None:
    text = Page(pages["sweep"]).text
    assert "These had been bent to hide what was missing: Re, Le, Rm." in text
    assert "+154" in text and "at its bound" in text and text.count("bent ") >= 3


def test_names_from_users_are_text_and_nothing_else() -> None:
    evil = '<script>alert("1")</script>&$x^{_$\'"]]>'
    v = verdicts.missing_backlash(400)
    effect = replace(v.effects[0], id=evil, says=evil, port=evil, source=evil)
    v = replace(
        v, model=evil, summary=evil, law=evil, notes=(evil,), noise=evil, unit=evil, extended_model=evil,
        mismatch=(Mismatch(evil, "z", 0.0, 1.0, evil, evil, evil),),
        effects=(replace(effect, equivalents=(evil,), separating_experiment=evil),),
        parameters=tuple(replace(p, name=evil + p.name, unit=evil) for p in v.parameters),
        trials=(Trial((evil,), evil, -5.0, 1, 1.0),),
        traces=tuple(replace(t, name=evil, unit=evil, axis=evil) for t in v.traces),
        curve=replace(v.curve, port=evil, quantity=evil, unit=evil, x_name=evil, x_unit=evil),
    )  # fmt: skip
    seen = Page(page(v))
    assert "script" not in seen.tags and not seen.wrong and not seen.open
    assert seen.text.count("alert(") > 10


def test_written_whole_or_not_at_all(tmp_path) -> None:
    write_html(verdicts.adequate(), tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text().rstrip().endswith("</html>")
    with pytest.raises(InputError, match="does not exist") as found:
        write_html(verdicts.adequate(), tmp_path / "none" / "a.html")
    assert "\n" not in str(found.value)
    assert [p.name for p in tmp_path.iterdir()] == ["a.html"]


def test_arguments_that_have_changed_places_are_told(tmp_path) -> None:
    path, v = tmp_path / "a.html", verdicts.adequate()
    with pytest.raises(InputError, match=r"^verdict: found something of type \w+, wanted a Verdict"):
        write_html(path, v)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="case: found something of type Model, wanted a Case"):
        write_html(v, path, load("kelvin_voigt"))  # type: ignore[arg-type]


def test_the_same_verdict_gives_the_same_page() -> None:
    v = verdicts.stiffness()
    assert page(v) == page(v)


def test_long_records_stay_small() -> None:
    v = verdicts.missing_semi_inductance(3)
    v = replace(v, traces=v.traces + verdicts.missing_backlash(400_000).traces)
    text = page(v)
    assert len(text.encode()) < 1_500_000


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("damage", ["nan", "one", "constant", "outliers", "many"])
def test_poor_recordings_are_drawn_all_the_same(damage) -> None:
    v = verdicts.missing_backlash(600)
    t = v.traces[0]
    nothing = np.full_like(t.before, np.nan)
    cut = {n: getattr(t, n)[:1] for n in ("x", "data", "before", "after", "outliers")}
    t = {
        "nan": lambda: replace(t, before=nothing, white_before=nothing[None]),
        "one": lambda: replace(
            t, **cut, white_before=t.white_before[:, :1], white_after=t.white_after[:, :1],
            inputs={k: x[:1] for k, x in t.inputs.items()},
        ),
        "constant": lambda: replace(t, data=0 * t.data, inputs={"t": t.x, "z": 0 * t.x}),
        "outliers": lambda: replace(t, outliers=np.ones_like(t.outliers)),
        "many": lambda: t,
    }[damage]()  # fmt: skip
    traces = tuple(replace(t, name=f"r{k}") for k in range(12)) if damage == "many" else (t,)
    text = Page(page(replace(v, traces=traces)))
    assert text.tags.count("svg") == 1 + min(len(traces), 6)
    if damage == "many":
        assert "6 of 12 recordings" in text.text and "r11" in text.text


def test_empty_verdict_has_a_page() -> None:
    v = replace(verdicts.adequate(), traces=(), trials=(), parameters=(), parameters_before=(), summary="")
    assert "Nothing is missing" in Page(page(v)).text


def test_what_is_missing_in_time_is_drawn_where_no_curve_is_given() -> None:
    v = replace(verdicts.missing_backlash(), curve=None)
    assert "a line over acceleration to a mass" in Page(page(v)).text
    held = v.traces[0]
    hold = replace(held, inputs={"t": held.x, "z": np.minimum(held.x, 2.0)})
    assert "the logarithm of time" in Page(page(replace(v, traces=(hold,)))).text
    assert "What is missing" not in Page(page(verdicts.adequate())).text


def test_units_of_inputs_come_from_the_model() -> None:
    v = replace(verdicts.missing_backlash(400), curve=None, mismatch=())
    assert "z [mm]" not in page(v)
    text = page(v, model=load("modified_dahl"))
    assert "z [mm]" in text and "speed [mm/s]" in text


def test_what_drives_a_model_is_not_taken_for_how_it_moves() -> None:
    """A mass on a spring, driven by u: no law over the stroke is read from what is missing over u."""
    from modelgen.language import Equation, Input, Model, Parameter, Port, State

    t, u, k = Input("t", "s"), Input("z", "N"), Parameter("k", "N/m", 1.0)
    at, speed = State("q", rate=0).symbol, State("w", rate=0).symbol
    pull = Equation("F", k * at, "N")
    m = Parameter("m", "kg", 1.0)
    states = (State("q", 0.0, rate=speed, unit="m"), State("w", 0.0, rate=(u - pull) / m, unit="m/s"))
    port = Port("force", "force", "F", (("z", at), ("v", speed)))
    driven = Model("driven", (t, u), (k, m), (pull, *states), ("F",), (port,))
    v = replace(verdicts.missing_backlash(400), curve=None, mismatch=())
    text = Page(page(v, model=driven)).text
    assert "The motion there is not recorded" in text and "belongs to a spring" not in text


# ---- the terminal


def shown(v, **options) -> str:
    out = StringIO()
    print_verdict(v, Console(file=out, width=80, **options))
    return out.getvalue()


@pytest.mark.parametrize("name", verdicts.ALL)
def test_terminal_is_short_and_plain_where_there_is_none(name) -> None:
    v = verdicts.ALL[name]()
    text = shown(v)
    assert len(text.splitlines()) <= 30
    assert "\x1b" not in text
    assert words.headline(v) in text
    assert "\x1b" in shown(v, force_terminal=True, color_system="standard")


def test_terminal_says_what_was_noticed() -> None:
    v = verdicts.missing_semi_inductance(3)
    assert f"Note: {v.notes[0][:20]}" in shown(v)


def test_terminal_says_the_verdict() -> None:
    text = shown(verdicts.missing_semi_inductance(3))
    for part in (
        "semi_inductance",
        "93 %",
        "eddy_shunt",
        "12.4",
        "1.01",
        "Next experiment",
        "out/electrodynamic",
    ):
        assert part in text
    two = verdicts.missing_backlash()
    two = replace(two, effects=(*two.effects, Finding("sensor_delay", "sensor", "Late.", 0.7)))
    assert "backlash and sensor delay" in shown(two)


def test_terminal_takes_markup_for_text() -> None:
    v = replace(verdicts.missing_backlash(), summary="[red]x[/nothing] [F_0]", extended_model="[/b].py")
    assert "[red]x[/nothing] [F_0]" in shown(v) and "[/b].py" in shown(v)


# ---- what a physicist reads off


@pytest.mark.parametrize(
    ("exponent", "unit", "says"),
    [
        (0.0, "N*s/m", "a dashpot"),
        (1.0, "N*s/m", "a mass"),
        (-1.0, "N*s/m", "a spring"),
        (0.5, "ohm", "the mark of diffusion"),
        (1.0, "ohm", "an inductance"),
        (0.0, "ohm", "a resistance"),
        (0.3, "N*s/m", "a power law, its phase that of its slope"),
        (1.0, "N/m", "a dashpot"),
        (2.0, "N/m", "a mass"),
    ],
)
def test_slope_names_the_element(exponent, unit, says) -> None:
    f = np.geomspace(1, 1e4, 50)
    law = 3 * (2j * np.pi * f) ** exponent
    for known in (law, None):
        curve = PortCurve("p", "impedance", unit, "f", "Hz", f, law, known, 1e-3 * np.abs(law))
        slope, phase, steady = slope_and_phase(curve)
        wrapped = (phase - 90 * exponent + 180) % 360 - 180
        assert slope == pytest.approx(exponent, abs=1e-9) and wrapped == pytest.approx(0, abs=1e-9) and steady
        assert slope_text(curve).endswith(f": {says}.")


def test_slope_of_a_relaxation_is_not_called_an_element() -> None:
    f = np.geomspace(1, 1e4, 50)
    law = 1 / (1 + 1j * f / 100)
    curve = PortCurve("p", "impedance", "ohm", "f", "Hz", f, law, law)
    assert "both change" in slope_text(curve)
    assert slope_text(replace(curve, x_name="z", log_x=False)) == ""


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=3000), st.integers(1, 200))
def test_thinning_keeps_the_extremes(values, bins) -> None:
    y = np.array(values)
    i = extremes(y, bins)
    assert np.all(np.diff(i) > 0) and len(i) <= max(2 * bins, 1) + 2
    assert y[i].min() == y.min() and y[i].max() == y.max()


def test_excerpt_holds_about_three_cycles_around_the_worst() -> None:
    t = np.arange(10_000) / 100.0
    misfit = np.where(np.abs(t - 70) < 0.5, 10.0, 0.1)
    part = excerpt(np.sin(2 * np.pi * t), misfit)
    assert t[part][0] < 69.6 and t[part][-1] > 70.4 and 2.9 < np.ptp(t[part]) < 3.2
    assert excerpt(np.linspace(0, 1, 500), np.ones(500)) == slice(0, 500)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_folding_keeps_order_and_the_noise_band(a, b) -> None:
    fa, fb = fold(np.array([a, b]))
    assert (fa - fb) * (a - b) >= 0
    if abs(a) <= 3:
        assert fa == a


@given(st.floats(-1e12, 1e12).filter(lambda x: abs(x) > 1e-12), st.integers(2, 6))
def test_numbers_read_back(x, digits) -> None:
    text = words.number(x, digits).replace("−", "-")
    head, _, power = text.partition("·10")
    back = float(head) * 10.0 ** int((power or "⁰").translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")))
    assert back == pytest.approx(x, rel=0.51 * 10.0 ** (1 - digits))


def test_words_of_numbers_and_units() -> None:
    assert words.measured(0.3834, 0.0012) == "0.3834 ± 0.0012"
    assert words.measured(-0.4, 140.0) == "0 ± 140"
    assert words.measured(1.2e-5, 3e-7) == "(1.200 ± 0.030)·10⁻⁵"
    assert words.measured(0.0, 0.5) == "0.00 ± 0.50"
    assert words.measured(2.5, float("nan")) == "2.500"
    assert words.number(float("nan")) == "–"
    assert [words.short(x) for x in (20000.0, 0.25, 1.5e-7)] == ["20000", "0.25", "1.5·10⁻⁷"]
    assert [words.percent(p) for p in (1.0, 0.5, 0.0)] == ["> 99 %", "50 %", "< 1 %"]
    assert [words.unit_text(u) for u in ("N*s/mm**2", "1", "ohm")] == ["N·s/mm²", "", "Ω"]
    assert words.unit_text("mm**3/(s*V*MPa**0.5)") == "mm³/(s·V·MPa⁰·⁵)"
    assert words.unit_text("(N*m**(-1))") == "(N·m⁻¹)"
    assert [plain(v) for v in (0.05, 20, 5e3, -1e-6, 2e7)] == ["0.05", "20", "5k", "−10⁻⁶", "2·10⁷"]


def test_formulas() -> None:
    assert symbol("k_D") == '<span class="sym"><i>k</i><sub>D</sub></span><small></small>'
    assert "ρ" in symbol("rho") and "[a&lt;b]" in symbol("F_0[a<b]")
    assert re.sub("<[^u].*?>|</[^u].*?>", "", formula("K*(j*omega)**(n + 1)")) == "K·(j·ω)n + 1"
    assert formula("x**2").endswith("<sup>2</sup>")
    assert formula("force falls with 1/gap") == "force falls with 1/gap"
    assert sentence("K(jω)^n and second_mode, v^2.") == "K(jω)<sup>n</sup> and second mode, v<sup>2</sup>."
    assert sentence("the rod is <loose> by 1.74e+03 mm") == "The rod is &lt;loose&gt; by 1740 mm."
    assert "eddy" not in formula("eddy_K*2", ["eddy"]) and "lag" in formula("lag_K + b_K", ["lag", "b"])
    assert "<i>a</i>" in formula("F = a*M") and formula("a force") == "a force"
    assert formula("0.666666666666667") == "0.6667"


def test_importing_the_room_loads_nothing_heavy() -> None:
    code = "import sys, modelgen.report; print({'matplotlib', 'jinja2', 'rich', 'numpy'} & set(sys.modules))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "set()"


def test_a_hypothesis_is_told_with_its_port_where_there_are_several() -> None:
    v = verdicts.missing_backlash()
    at = replace(v.trials[0], ports=("drive",))
    text = Page(page(replace(v, trials=(at, *v.trials[1:])))).text
    assert "backlash at drive" in text and "second Dahl element at" not in text
