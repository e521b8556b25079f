"""Fig. 2: force and stretch of cloth."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from taut.figures.pull import Curve, membrane_stiffness, pull_strip
from taut.figures.scenes import LIMIT, STRIP
from taut.figures.section import Finding, Section
from taut.figures.workshop import Ink, Workshop


def figure_2(shop: Workshop) -> Section:
    """Pull a strip without and with the constraint."""
    shop.watch("strip, without the constraint", 1, 2, "")
    bare = pull_strip(shop.size, "none")
    shop.watch("strip, with the constraint", 2, 2, "")
    limited = pull_strip(shop.size, "coarse_to_fine")

    def draw(figure: Figure, ink: Ink) -> None:
        axes = figure.subplots()
        end = 1.04 * bare.stretch[-1]
        axes.plot([0, end], [0, end * membrane_stiffness()], color=ink.text, linewidth=0.8, linestyle=":")
        for curve, color, name in (
            (bare, ink.bare, "without"),
            (limited, ink.limited, "with the constraint"),
        ):
            axes.plot((0, *curve.stretch), (0, *curve.pull), "o-", color=color, markersize=4, label=name)
        axes.axvline(LIMIT, color=ink.text, linewidth=0.8, linestyle="--")
        axes.annotate("λ", (LIMIT, axes.get_ylim()[1]), (4, -12), textcoords="offset points")
        axes.set(xlabel="stretch of the strip", ylabel="pull [N/m]", xlim=(0, end), ylim=(0, None))
        axes.xaxis.set_major_formatter(PercentFormatter(1, decimals=0))
        axes.legend(loc="lower right")

    caption = (
        "Pull against stretch: without the constraint a straight line, with it a line that turns upright"
        " just below λ (dotted: the theory of a linear membrane)"
    )
    within = [abs(s / (p / membrane_stiffness()) - 1) for s, p in zip(bare.stretch, bare.pull, strict=True)]
    steeper = _slope(limited) / _slope(bare)
    held = limited.worst[-1] <= LIMIT + 1e-5
    return Section(
        number="Fig. 2",
        title="Force and stretch of cloth",
        claim=(
            "Cloth is nearly linear while it is stretched little; beyond some stretch its stiffness rises"
            " steeply. A linear mass-spring cloth lacks that rise, and so gives way without bound."
        ),
        setting=(
            f"A strip of {STRIP[0]:g} m x {STRIP[1]:g} m hangs from its upper edge, with ever larger masses"
            f" along the lower one, λ = {100 * LIMIT:g} %; each point is an equilibrium."
        ),
        verdict="holds" if held and steeper > 5 else "does not hold",
        reading=(
            f"The bare strip follows the linear theory ({membrane_stiffness():.1f} N/m) within"
            f" {100 * max(within):.0f} %; its ends cannot narrow. With the"
            " constraint it does the same up to a knee just below λ and then takes any pull: over the"
            f" upper half of the loads it is {steeper:.0f} times as steep. The strip as a whole stays"
            f" {100 * (LIMIT - limited.stretch[-1]):.1f} points below λ, because its springs are not"
            " stretched evenly and the filter aims a little below their limit."
        ),
        columns=("without", "with"),
        findings=(
            _finding(f"stretch at {bare.pull[-1]:g} N/m", bare.stretch[-1], limited.stretch[-1]),
            _finding("worst spring there", bare.worst[-1], limited.worst[-1]),
        ),
        pictures=(shop.plot("fig2", caption, (6.4, 3.8), draw),),
        numbers={
            "pull_N_per_m": bare.pull[-1],
            "stretch_without": bare.stretch[-1],
            "stretch_with": limited.stretch[-1],
            "worst_without": bare.worst[-1],
            "worst_with": limited.worst[-1],
            "largest_error_of_linear_theory": max(within),
            "times_as_steep": steeper,
        },
    )


def _slope(curve: Curve) -> float:
    """Pull over stretch in the upper half of the loads [N/m]."""
    half = len(curve.pull) // 2
    gained = np.ptp(curve.stretch[half - 1 :])
    return float(np.ptp(curve.pull[half - 1 :]) / max(float(gained), 1e-4))


def _finding(what: str, bare: float, limited: float) -> Finding:
    return Finding(what, (f"{100 * bare:.1f} %", f"{100 * limited:.1f} %"))
