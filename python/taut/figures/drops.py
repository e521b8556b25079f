"""Fig. 6 to 9: a sheet that is let go, on its way and at rest."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from taut.cache import Cache
from taut.compare.measure import Body, fall, rest_time, speed
from taut.figures.scenes import LIMIT, sheet
from taut.figures.section import Finding, Picture, Section, Verdict
from taut.figures.workshop import Ink, Workshop
from taut.render import RenderOptions, render_still, render_strip
from taut.scene import Scene
from taut.simulation import Simulation

_MOMENTS = (0.0, 0.12, 0.24, 0.4, 0.66, 1.0)
"""Of the strips, as shares of the time."""

_NEAR = 0.2
"""Springs within so much of the size of the sheet are near the pin [1]."""

_SETTLED = 0.01
"""The height has settled when the centre of mass stays so near to where it ends [m]; it has turned when it
has gone so far since the last turn."""


def figures_6_and_7(shop: Workshop) -> Section:
    """One corner held, frame by frame."""
    bare, limited = (
        shop.simulate(sheet(shop.size, 1, shop.size.drop_seconds, method, f"One corner, {words}"))
        for method, words in (("none", "without the constraint"), ("coarse_to_fine", "with the constraint"))
    )
    times = [share * float(bare.time[-1]) for share in _MOMENTS]
    name = "fig6-7.jpg"
    render_strip(
        [bare, limited],
        times,
        shop.pictures / name,
        RenderOptions(color="strain", size=shop.panels(400, 420)),
    )
    near, far = zip(*(_near_and_far(cache) for cache in (bare, limited)), strict=True)
    reach = [_reach(cache) for cache in (bare, limited)]
    deepest = [float(fall(cache, _body(cache)).max()) for cache in (bare, limited)]
    kept = near[1] <= LIMIT + 1e-5 < near[0] and deepest[1] < deepest[0]
    return Section(
        number="Fig. 6 and 7",
        title="A sheet held by one corner is dropped",
        claim=(
            "Without the constraint (Fig. 6) the mesh near the pin is deformed very much. With it (Fig. 7)"
            " it is not over-stretched there, and the cloth as a whole strays less from its place: it"
            " looks like hanging cloth."
        ),
        setting=(
            f"A level sheet of 1 m x 1 m, {shop.size.sheet} x {shop.size.sheet} cells, λ = {100 * LIMIT:g}"
            " %, held by one corner. Above without, below with the constraint."
        ),
        verdict="holds" if kept else "does not hold",
        reading=(
            f"The springs within {100 * _NEAR:g} cm of the pin get up to {1 + near[0]:.1f} times as long as"
            f" at rest without the constraint, and {1 + near[1]:.2f} times with it. The centre of mass"
            f" falls {deepest[0]:.2f} m instead of {deepest[1]:.2f} m, and the furthest particle gets"
            f" {reach[0]:.2f} m away from the pin instead of {reach[1]:.2f} m; the sheet's diagonal is 1.41"
            " m."
        ),
        columns=("without", "with"),
        findings=(
            Finding(f"worst spring within {100 * _NEAR:g} cm of the pin", _percent(near)),
            Finding("worst spring elsewhere", _percent(far)),
            Finding("deepest fall of the centre of mass", _metres(deepest)),
            Finding("furthest from the pin", _metres(reach)),
        ),
        pictures=(Picture(name, "Six moments, coloured by stretch", wide=True),),
        numbers={
            "near_without": near[0],
            "near_with": near[1],
            "far_without": far[0],
            "far_with": far[1],
            "fall_without_m": deepest[0],
            "fall_with_m": deepest[1],
            "reach_without_m": reach[0],
            "reach_with_m": reach[1],
        },
    )


@dataclass(frozen=True, slots=True)
class _Rest:
    """How a sheet comes to rest."""

    cache: Cache
    time: float | None
    """From when on [s]."""
    settled: float
    """From when on the height of the centre of mass has settled [s]."""
    turns: int
    """Turns of that height until the end [1]."""
    worst: float
    """Stretch of the worst spring at the end [1]."""
    upper: float
    """Mean stretch of the springs that hang highest, a tenth of all, at the end [1]."""

    @classmethod
    def of(cls, cache: Cache) -> "_Rest":
        body = _body(cache)
        last = cache.stretch(-1)
        heights = cache.positions(-1)[:, 2][cache.springs].mean(axis=1)
        highest = heights >= np.quantile(heights, 0.9)
        return cls(
            cache=cache,
            time=rest_time(cache, body),
            settled=_settled(cache, body),
            turns=_turns(fall(cache, body)),
            worst=float(last.max()),
            upper=float(last[highest].mean()),
        )


def figures_8_and_9(shop: Workshop) -> Section:
    """At rest under two pins and under one."""
    runs: dict[tuple[int, str], _Rest] = {}
    for method, words in (("none", "without"), ("coarse_to_fine", "with")):
        for pins, held in ((2, "two corners"), (1, "one corner")):
            title = f"{held.capitalize()}, {words} the constraint"
            document = sheet(shop.size, pins, shop.size.rest_seconds, method, title)
            runs[pins, words] = _Rest.of(shop.simulate(document))
    name = "fig8-9.jpg"
    options = RenderOptions(color="strain", size=shop.panels(440, 520), columns=4)
    render_still([rest.cache for rest in runs.values()], shop.pictures / name, options)
    sooner = {pins: _sooner(runs[pins, "without"].time, runs[pins, "with"].time) for pins in (2, 1)}
    settled = {pins: _sooner(runs[pins, "without"].settled, runs[pins, "with"].settled) for pins in (2, 1)}
    flat = all(runs[pins, "with"].worst <= LIMIT + 1e-5 < runs[pins, "without"].worst for pins in (2, 1))
    quick = [share is not None and share > 0.05 for share in (*sooner.values(), *settled.values())]
    verdict: Verdict = (
        "holds" if flat and all(quick) else "holds in part" if flat or any(quick) else "does not hold"
    )
    every = list(runs)
    return Section(
        number="Fig. 8 and 9",
        title="At rest under two pins and under one",
        claim=(
            "Without the constraint (Fig. 8) the cloth hangs visibly over-stretched, sags from its upper"
            " part and goes up and down repeatedly before it is at rest. With it (Fig. 9) over-stretching"
            " is avoided to some extent, and the cloth reaches its place after a shorter time and looks"
            " more real."
        ),
        setting=(
            f"The sheet of Fig. 6, with more air drag (0.5 1/s), for {shop.size.rest_seconds:g} s. At rest:"
            f" it moves by less than {_body(runs[1, 'with'].cache).rest_speed or 0:.3f} m/s (root mean"
            " square, from frame to frame) until the end."
        ),
        verdict=verdict,
        reading=(
            f"The over-stretching at rest is gone. The height settles {_sooner_words(settled[2])} with two"
            f" pins and {_sooner_words(settled[1])} with one, after fewer turns of the centre of mass: the"
            " constraint takes the bouncing away. But the whole cloth is at rest"
            f" {_sooner_words(sooner[2])} with two pins and {_sooner_words(sooner[1])} with one: a cloth"
            " that is taut still swings like a pendulum, and then only the air slows it down."
        ),
        columns=tuple(f"{'two pins' if pins == 2 else 'one pin'}, {words}" for pins, words in every),
        findings=(
            Finding("worst spring at rest", _percent([runs[key].worst for key in every])),
            Finding("mean of the highest tenth", _percent([runs[key].upper for key in every])),
            Finding("height settled after", tuple(_seconds(runs[key].settled) for key in every)),
            Finding("turns of the height", tuple(str(runs[key].turns) for key in every)),
            Finding("at rest after", tuple(_seconds(runs[key].time) for key in every)),
        ),
        pictures=(
            Picture(name, "At the end, coloured by stretch", wide=True),
            shop.plot("fig8-9-height", _HEIGHT_CAPTION, (6.4, 4.6), lambda f, ink: _draw(f, ink, runs)),
        ),
        numbers={
            **{f"worst_{pins}_{words}": runs[pins, words].worst for pins, words in every},
            **{f"rest_{pins}_{words}_s": runs[pins, words].time for pins, words in every},
            **{f"settled_{pins}_{words}_s": runs[pins, words].settled for pins, words in every},
            **{f"turns_{pins}_{words}": float(runs[pins, words].turns) for pins, words in every},
            **{f"sooner_{pins}": share for pins, share in sooner.items()},
        },
    )


_HEIGHT_CAPTION = "Fall of the centre of mass, and the speed that tells rest, two pins above and one below"


def _draw(figure: Figure, ink: Ink, runs: dict[tuple[int, str], _Rest]) -> None:
    panels = figure.subplots(2, 2, sharex=True, sharey="col")
    for (pins, words), rest in runs.items():
        body = _body(rest.cache)
        row = panels[0 if pins == 2 else 1]
        color = ink.bare if words == "without" else ink.limited
        row[0].plot(rest.cache.time, -fall(rest.cache, body), color=color, label=words, linewidth=1.3)
        row[1].plot(rest.cache.time[1:], speed(rest.cache, body)[1:], color=color, linewidth=1.0)
        row[1].axhline(body.rest_speed or 0, color=ink.text, linewidth=0.8, linestyle="--")
        row[0].set_ylabel(f"{'two pins' if pins == 2 else 'one pin'}\nfall [m]")
        row[1].set(yscale="log", ylabel="speed [m/s]")
    panels[0][0].legend(fontsize=9)
    for axes in panels[1]:
        axes.set_xlabel("time [s]")


def _body(cache: Cache) -> Body:
    return Body.of(Simulation(Scene(cache.scene), 1))


def _near_and_far(cache: Cache) -> tuple[float, float]:
    """Worst stretch near the pin and elsewhere, over all frames [1]."""
    rest = cache.positions(0).astype(np.float64)
    away = np.linalg.norm(rest - rest[cache.pins[0]], axis=1)[cache.springs].max(axis=1)
    worst: NDArray[np.float32] = np.max([cache.stretch(frame) for frame in range(cache.frames)], axis=0)
    return float(worst[away <= _NEAR].max(initial=0.0)), float(worst[away > _NEAR].max())


def _reach(cache: Cache) -> float:
    """Largest distance of any particle from the pin in any frame [m]."""
    pin = cache.positions(0)[cache.pins[0]].astype(np.float64)
    frames = (cache.positions(frame) - pin for frame in range(cache.frames))
    return max(float(np.linalg.norm(x, axis=1).max()) for x in frames)


def _settled(cache: Cache, body: Body) -> float:
    """From when on the height of the centre of mass stays near its last value [s]."""
    heights = fall(cache, body)
    away = np.flatnonzero(np.abs(heights - heights[-1]) > _SETTLED)
    return float(cache.time[away[-1] + 1]) if away.size else 0.0


def _turns(heights: NDArray[np.float64]) -> int:
    """How often a height goes from up to down or back, small tremors left out."""
    turns, way, extreme = 0, 0.0, float(heights[0])
    for height in map(float, heights):
        if way * (height - extreme) > 0 or way == 0 and abs(height - extreme) > _SETTLED:
            way, extreme = height - extreme if way == 0 else way, height
        elif abs(height - extreme) > _SETTLED:
            turns, way, extreme = turns + 1, height - extreme, height
    return turns


def _sooner(bare: float | None, limited: float | None) -> float | None:
    """How much sooner the one with the constraint gets there, as a share [1]."""
    return None if not bare or limited is None else 1 - limited / bare


def _sooner_words(share: float | None) -> str:
    if share is None:
        return "not in this time"
    return f"{100 * abs(share):.0f} % {'sooner' if share > 0 else 'later'}"


def _percent(shares: "tuple[float, ...] | list[float]") -> tuple[str, ...]:
    return tuple(f"{100 * share:.1f} %" for share in shares)


def _metres(lengths: list[float]) -> tuple[str, ...]:
    return tuple(f"{length:.2f} m" for length in lengths)


def _seconds(time: float | None) -> str:
    return "not yet" if time is None else f"{time:.1f} s"
