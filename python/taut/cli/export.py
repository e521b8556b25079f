"""``taut export``."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from taut.cli.arguments import Yes
from taut.cli.console import Bar, expected_errors, make_folder_of


class Format(StrEnum):
    """What to export to."""

    OBJ = "obj"
    PC2 = "pc2"
    PLY = "ply"


def command(
    cache: Annotated[Path, typer.Argument(help="A cache that `taut run` wrote.", metavar="CACHE.zarr")],
    to: Annotated[Format, typer.Option(help="The format.")],
    out: Annotated[Path, typer.Option(help="A folder for obj and ply (one file a frame), a file for pc2.")],
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an earlier export.")] = False,
    yes: Yes = False,
) -> None:
    """Write the frames in another format; vertices keep their order."""
    with expected_errors():
        from taut.cache import Cache
        from taut.formats import export

        opened = Cache.open(cache)
        make_folder_of(out, yes)
        with Bar(out.name) as bar:
            export(opened, to.value, out, overwrite=overwrite, progress=bar.update)
