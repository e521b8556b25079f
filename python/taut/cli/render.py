"""``taut render``."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from taut.cli.arguments import Yes
from taut.cli.console import Bar, expected_errors, make_folder_of


class Color(StrEnum):
    """What the cloth's colour shows."""

    STRAIN = "strain"
    FABRIC = "fabric"


def command(
    caches: Annotated[list[Path], typer.Argument(help="Caches to show side by side.", metavar="CACHE.zarr")],
    out: Annotated[Path, typer.Option(help="A film (.mp4) or a still (.png).", metavar="film.mp4|still.png")],
    frame: Annotated[int | None, typer.Option(help="Of a still: -1 is the last, the default.")] = None,
    color: Annotated[Color, typer.Option(help="Heat map of the stretch, or plain cloth.")] = Color.STRAIN,
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
        opened = [Cache.open(cache) for cache in caches]
        make_folder_of(out, yes)
        with Bar(out.name) as bar:
            options = RenderOptions(frame=frame, color=color.value, overwrite=overwrite, progress=bar.update)
            (render_film if film else render_still)(opened, out, options)
