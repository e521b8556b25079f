"""``taut export``."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from taut.cli.arguments import Yes
from taut.cli.console import BAD_INPUT, Bar, expected_errors, fail, make_folder_of


class Format(StrEnum):
    """What to export to."""

    OBJ = "obj"
    PC2 = "pc2"
    PLY = "ply"


def command(
    cache: Annotated[Path, typer.Argument(help="A cache that `taut run` wrote.", metavar="CACHE.zarr")],
    to: Annotated[Format, typer.Option(help="The format.")],
    out: Annotated[Path, typer.Option(help="A folder for obj and ply (one file a frame), a file for pc2.")],
    like: Annotated[
        list[str] | None,
        typer.Option(
            help="For obj: keep texture coordinates, groups, materials, normals and faces of this OBJ file, "
            "of which the cloth was made.",
            metavar="[CLOTH=]MESH.obj",
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an earlier export.")] = False,
    yes: Yes = False,
) -> None:
    """Write the frames in another format; vertices keep their order."""
    with expected_errors():
        from taut.cache import Cache
        from taut.formats import export

        opened = Cache.open(cache)
        make_folder_of(out, yes)
        meshes = [cloth["name"] for cloth in opened.scene["cloth"] if cloth.get("mesh")]
        own = dict(_named(text, meshes) for text in like or [])
        with Bar(out.name) as bar:
            export(opened, to.value, out, overwrite=overwrite, progress=bar.update, like=own)


def _named(text: str, meshes: list[str]) -> tuple[str, str]:
    """The cloth that a file is for, and the file; the cloth need not be said where only one has a mesh."""
    name, is_said, path = text.partition("=")
    if is_said:
        return name, path
    if len(meshes) != 1:
        found = f"{len(meshes)} cloths have meshes"
        raise fail(f"--like {text}: {found}; say which it is for, as in --like shirt={text}", BAD_INPUT)
    return meshes[0], text
