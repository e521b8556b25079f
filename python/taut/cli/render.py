"""``taut render``."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from taut.cli.arguments import Yes
from taut.cli.console import BAD_INPUT, Bar, expected_errors, fail, make_folder_of


class Color(StrEnum):
    """What the cloth's colour shows."""

    STRAIN = "strain"
    FABRIC = "fabric"


def command(
    caches: Annotated[list[Path], typer.Argument(help="Caches to show side by side.", metavar="CACHE.zarr")],
    out: Annotated[Path, typer.Option(help="A film (.mp4) or a still (.png).", metavar="film.mp4|still.png")],
    frame: Annotated[int | None, typer.Option(help="Of a still: -1 is the last, the default.")] = None,
    color: Annotated[Color, typer.Option(help="Plain cloth, or a heat map of its stretch.")] = Color.FABRIC,
    size: Annotated[
        str | None, typer.Option(help="Of each cache's panel [pixels]; default: 800x720.", metavar="WxH")
    ] = None,
    fps: Annotated[float | None, typer.Option(help="Of a film; default: that of the scene.")] = None,
    camera: Annotated[
        str | None,
        typer.Option(help="Where it stands [m]; default: all motion is in view.", metavar="X,Y,Z"),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(
            help="What the camera looks at [m]; default: the middle of all motion.", metavar="X,Y,Z"
        ),
    ] = None,
    background: Annotated[
        str | None,
        typer.Option(help="A colour in place of sky and ground: white, #102030.", metavar="COLOUR"),
    ] = None,
    caption: Annotated[bool, typer.Option(help="Title, time and worst stretch above each panel.")] = True,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an earlier picture.")] = False,
    yes: Yes = False,
) -> None:
    """Make a film or a still of one or more caches."""
    with expected_errors():
        from taut.cache import Cache
        from taut.render import FILM_EXTENSIONS, RenderError, RenderOptions, render_film, render_still

        film = out.suffix.lower() in FILM_EXTENSIONS
        if film and frame is not None:
            raise RenderError(
                f"--frame {frame} chooses a frame for a still, but {out} is a film; name a .png"
            )
        if fps is not None and not film:
            raise RenderError(f"--fps {fps:g} is of a film, but {out} is none; name a .mp4")
        with Bar(out.name) as bar:
            options = RenderOptions(
                frame=frame,
                color=color.value,
                size=_numbers("size", size, "1280x720", int) or RenderOptions.size,
                eye=_numbers("camera", camera, "3,-4,1.5", float),
                target=_numbers("target", target, "0,0,1.5", float),
                fps=fps,
                background=background,
                caption=caption,
                overwrite=overwrite,
                progress=bar.update,
            )
            opened = [Cache.open(cache) for cache in caches]
            make_folder_of(out, yes)
            (render_film if film else render_still)(opened, out, options)


def _numbers(option: str, text: str | None, example: str, kind: type) -> Any:
    """As many numbers as in the example, and parted alike; nothing where the option was left out."""
    if text is None:
        return None
    between = "x" if "x" in example else ","
    try:
        numbers = tuple(kind(part) for part in text.split(between))
    except ValueError:
        numbers = ()
    if len(numbers) != len(example.split(between)):
        raise fail(f"--{option} {text}: must be numbers as in {example}", BAD_INPUT)
    return numbers
