"""Fig. 4 and 5: flags in the wind."""

import numpy as np
from numpy.typing import NDArray

from taut.cache import Cache
from taut.figures.scenes import FLAG_LIMIT, flag
from taut.figures.section import Finding, Picture, Section
from taut.figures.workshop import Workshop
from taut.render import RenderOptions, render_still

_SPEEDS = (3.0, 8.0, 16.0)
_ANGLES = (10.0, -50.0)
"""Where the wind blows to, from the plane of the flag at its start [degrees]."""


def figure_4(shop: Workshop) -> Section:
    """Three wind speeds from two directions."""
    flown: dict[tuple[float, float], Cache] = {}
    for angle in _ANGLES:
        for speed in _SPEEDS:
            way = np.radians(angle)
            wind = (speed * float(np.cos(way)), speed * float(np.sin(way)), 0.0)
            title = f"Wind of {speed:g} m/s towards {angle:g}°"
            document = flag(shop.size, wind, "coarse_to_fine", title)
            flown[angle, speed] = shop.simulate(document)
    name = "fig4.jpg"
    options = RenderOptions(color="fabric", size=shop.panels(480, 400), columns=len(_SPEEDS))
    render_still(list(flown.values()), shop.pictures / name, options)
    hang = {key: _hang(cache) for key, cache in flown.items()}
    turn = {key: _turn(cache) for key, cache in flown.items()}
    rising = all(
        hang[angle, low] > hang[angle, high]
        for angle in _ANGLES
        for low, high in zip(_SPEEDS, _SPEEDS[1:], strict=False)
    )
    off = max(abs(turn[key] - key[0]) for key in flown)
    columns = tuple(f"{speed:g} m/s" for speed in _SPEEDS)
    rows = []
    for angle in _ANGLES:
        cells = [(hang[angle, speed], turn[angle, speed]) for speed in _SPEEDS]
        rows.append(
            Finding(f"wind towards {angle:g}°: hangs at", tuple(f"{down:.0f}°" for down, _ in cells)),
        )
        rows.append(Finding("… points to", tuple(f"{aside:.0f}°" for _, aside in cells)))
    worst = max(float(cache.diagnostics["worst_stretch"].max()) for cache in flown.values())
    return Section(
        number="Fig. 4",
        title="Wind of different strength and direction",
        claim="Strength and direction of the wind on a flag follow from the parameters of the wind.",
        setting=(
            f"A flag of 1.5 m x 1 m, {shop.size.flag[0]} x {shop.size.flag[1]} cells, λ ="
            f" {100 * FLAG_LIMIT:g} %, in winds with gusts of 30 %. Angles are means over the second half"
            " of the time: how far the line from the middle of the pole to the middle of the free edge"
            " points down, and where it points seen from above."
        ),
        verdict="holds" if rising and off < 15 else "holds in part",
        reading=(
            f"The flag {'rises' if rising else 'does not always rise'} with the strength of the wind, and"
            f" points where the wind blows within {off:.0f}°. No spring was over {100 * worst:.2f} %."
        ),
        columns=columns,
        findings=tuple(rows),
        pictures=(
            Picture(name, "Six flags at the same moment: three strengths, two directions of the wind"),
        ),
        numbers={
            **{f"hang_{angle:g}_{speed:g}_deg": hang[angle, speed] for angle, speed in flown},
            **{f"turn_{angle:g}_{speed:g}_deg": turn[angle, speed] for angle, speed in flown},
            "worst_stretch": worst,
        },
    )


def figure_5(shop: Workshop) -> Section:
    """The flag without and with the constraint."""
    titles = {
        "none": "Flag, without the velocity constraint",
        "coarse_to_fine": "Flag, with the velocity constraint",
    }
    bare, limited = (
        shop.simulate(flag(shop.size, (8.0, 1.5, 0.0), method, title)) for method, title in titles.items()
    )
    name = "fig5.jpg"
    frame = round(0.8 * (bare.frames - 1))
    render_still(
        [bare, limited],
        shop.pictures / name,
        RenderOptions(color="strain", frame=frame, size=shop.panels(760, 560)),
    )
    worst = [float(cache.diagnostics["worst_stretch"].max()) for cache in (bare, limited)]
    length = [_thread_stretch(cache) for cache in (bare, limited)]
    over = [_share_over(cache) for cache in (bare, limited)]
    return Section(
        number="Fig. 5",
        title="The flag without and with the constraint",
        claim="Without the constraint the flag is stretched far too much; with it that does not happen.",
        setting="The flag of Fig. 4 in a wind of 8 m/s.",
        verdict="holds" if worst[1] <= FLAG_LIMIT + 1e-5 < worst[0] else "does not hold",
        reading=(
            f"Without, the worst spring gets {1 + worst[0]:.1f} times as long as at rest, and"
            f" {100 * over[0]:.0f} % of all springs are over λ; with the constraint none is in any frame."
            f" The flag itself gets {1 + length[0]:.2f} times as long without, and {1 + length[1]:.2f}"
            " times with it."
        ),
        columns=("without", "with"),
        findings=(
            Finding("worst spring", tuple(f"{100 * x:.1f} %" for x in worst)),
            Finding("springs over λ, all frames", tuple(f"{100 * x:.1f} %" for x in over)),
            Finding("most stretched thread, pole to free edge", tuple(f"{100 * x:.1f} %" for x in length)),
        ),
        pictures=(Picture(name, "The same moment of both, coloured by stretch", wide=True),),
        numbers={
            "worst_without": worst[0],
            "worst_with": worst[1],
            "over_without": over[0],
            "over_with": over[1],
            "thread_without": length[0],
            "thread_with": length[1],
        },
    )


def _late(cache: Cache) -> range:
    """The frames of the second half."""
    return range(cache.frames // 2, cache.frames)


def _line(cache: Cache) -> NDArray[np.float64]:
    """From the middle of the pole to the middle of the free edge, mean over the second half [m]."""
    columns, rows = (count + 1 for count in cache.scene["cloth"][0]["grid"]["cells"])
    base = columns * (rows // 2)
    lines = [x[base + columns - 1] - x[base] for x in map(cache.positions, _late(cache))]
    mean: NDArray[np.float64] = np.mean(lines, axis=0, dtype=np.float64)
    return mean


def _hang(cache: Cache) -> float:
    """How far that line points down [degrees]."""
    x, y, z = _line(cache)
    return float(np.degrees(np.arctan2(-z, np.hypot(x, y))))


def _turn(cache: Cache) -> float:
    """Where it points, seen from above, from the x axis [degrees]."""
    x, y, _ = _line(cache)
    return float(np.degrees(np.arctan2(y, x)))


def _thread_stretch(cache: Cache) -> float:
    """Stretch of the weft thread that is longest over its rest length in any frame [1]."""
    columns, rows = (count + 1 for count in cache.scene["cloth"][0]["grid"]["cells"])
    longest = 0.0
    for frame in range(cache.frames):
        x = cache.positions(frame).astype(np.float64).reshape(rows, columns, 3)
        lengths = np.linalg.norm(np.diff(x, axis=1), axis=2).sum(axis=1)
        longest = max(longest, float(lengths.max()))
    return longest / float(cache.scene["cloth"][0]["grid"]["size"][0]) - 1


def _share_over(cache: Cache) -> float:
    """Share of springs over their limit, over all frames [1]."""
    over = [(cache.stretch(frame) > cache.strain_limit + 1e-5).mean() for frame in range(cache.frames)]
    return float(np.mean(over))
