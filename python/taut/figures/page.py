"""The page: sections one below the other, light or dark as the reader's machine is, on any width."""

from collections.abc import Sequence
from html import escape

from taut.figures.section import Picture, Section

_STYLE = """
:root { color-scheme: light dark; --paper: #fbfcfd; --ink: #1f2933; --faint: #5c6975; --line: #dde4ea;
  --card: #ffffff; --good: #1b7f4b; --part: #9a6a00; --bad: #b3141f; }
@media (prefers-color-scheme: dark) { :root { --paper: #14181c; --ink: #e3e8ed; --faint: #9aa6b2;
  --line: #2c343c; --card: #1b2026; --good: #5fd39a; --part: #f0be5a; --bad: #ff8a85; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 17px/1.6 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main { max-width: 62rem; margin: 0 auto; padding: 2.5rem 1.2rem 4rem; }
h1 { font-size: clamp(1.6rem, 4vw, 2.3rem); line-height: 1.2; margin: 0 0 .6rem; }
h2 { font-size: 1.35rem; line-height: 1.3; margin: 0; }
h2 small { display: block; color: var(--faint); font-size: .85rem; font-weight: 600; letter-spacing: .04em; }
p { margin: .6rem 0; max-width: 46rem; }
nav { display: flex; flex-wrap: wrap; gap: .4rem .9rem; margin: 1.2rem 0 0; font-size: .95rem; }
a { color: inherit; text-decoration-color: var(--faint); text-underline-offset: .2em; }
section { border-top: 1px solid var(--line); margin-top: 2.4rem; padding-top: 1.6rem; }
.faint, figcaption { color: var(--faint); font-size: .92rem; }
.claim { border-left: 3px solid var(--line); padding-left: 1rem; }
.verdict { font-weight: 650; }
.holds { color: var(--good); } .in-part { color: var(--part); } .not { color: var(--bad); }
figure { margin: 1.2rem 0; }
figure img { display: block; width: 100%; height: auto; border-radius: 8px; }
.plot img { max-width: 44rem; }
.wide { overflow-x: auto; border-radius: 8px; }
.wide img { min-width: 46rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .95rem; }
th, td { text-align: right; padding: .35rem .9rem .35rem 0; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; min-width: 11rem; }
th { font-weight: 600; color: var(--faint); }
footer { margin-top: 3rem; border-top: 1px solid var(--line); padding-top: 1rem; }
"""

_VERDICTS = {
    "holds": ("holds", "The claim holds."),
    "holds in part": ("in-part", "The claim holds in part."),
    "does not hold": ("not", "The claim does not hold."),
}


def page(sections: Sequence[Section], made: str) -> str:
    """The whole page as HTML.

    Args:
        sections: what is on it, in order.
        made: with what and on what it was made.
    """
    links = "".join(f'<a href="#{_anchor(section)}">{escape(section.number)}</a>' for section in sections)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>The figures of the paper, made again</title>
<style>{_STYLE}</style>
</head>
<body>
<main>
<h1>The figures of the paper, made again</h1>
<p>Sun, Zhao and Liu, <i>Dynamic cloth simulation based on velocity constraint</i> (Computer Engineering
and Applications 44(31), 2008), show what a limit on the velocities does to cloth of masses and springs. Here
is each of their figures of cloth with what the paper says about it, made again by taut, and what we have
measured. The paper gives neither sizes nor constants, so those are ours; &ldquo;with the constraint&rdquo; is
the filter <code>coarse_to_fine</code>, which keeps the paper's inequality for every spring. (The steps of
the paper to the letter, <code>sequential</code>, stop taut cloth from swinging: <code>taut compare</code>.)
&ldquo;Stretch&rdquo; is the length of a spring over that at rest, less one; λ is its limit.</p>
<nav aria-label="Figures">{links}</nav>
{"".join(map(_section, sections))}
<footer class="faint">{escape(made)} Figures for programs: <a href="figures.json">figures.json</a>.</footer>
</main>
</body>
</html>
"""


def _section(section: Section) -> str:
    kind, sentence = _VERDICTS[section.verdict]
    return f"""
<section id="{_anchor(section)}">
<h2><small>{escape(section.number)}</small>{escape(section.title)}</h2>
<p class="claim"><span class="faint">The paper.</span> {escape(section.claim)}</p>
<p class="faint">{escape(section.setting)}</p>
{"".join(map(_figure, section.pictures))}
{_table(section)}
<p><span class="verdict {kind}">{sentence}</span> {escape(section.reading)}</p>
</section>
"""


def _figure(picture: Picture) -> str:
    image = f'<img src="pictures/{picture.name}" alt="{escape(picture.caption)}" loading="lazy">'
    if picture.dark:
        dark = f'<source srcset="pictures/{picture.dark}" media="(prefers-color-scheme: dark)">'
        image = f"<picture>{dark}{image}</picture>"
    box = f'<div class="wide" tabindex="0">{image}</div>' if picture.wide else image
    kind = ' class="plot"' if picture.dark else ""
    return f"<figure{kind}>{box}<figcaption>{escape(picture.caption)}.</figcaption></figure>\n"


def _table(section: Section) -> str:
    head = "".join(f"<th>{escape(column)}</th>" for column in section.columns)
    rows = ""
    for finding in section.findings:
        cells = "".join(f"<td>{escape(value)}</td>" for value in finding.values)
        rows += f"<tr><td>{escape(finding.what)}</td>{cells}</tr>\n"
    return f'<div class="scroll"><table><tr><th></th>{head}</tr>\n{rows}</table></div>'


def _anchor(section: Section) -> str:
    return section.number.lower().replace(".", "").replace(" ", "-")
