"""``taut new``."""

import os
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from taut.cli.console import BAD_INPUT, expected_errors, fail, warn


class Kind(StrEnum):
    """What to start with."""

    FLAG = "flag"
    HANGING = "hanging"


class Up(StrEnum):
    """The axis that points up."""

    Z = "z"
    Y = "y"


def command(
    name: Annotated[str, typer.Argument(help="Of the scene: NAME.toml is written.", metavar="NAME")],
    kind: Annotated[
        Kind | None,
        typer.Option(help="A flag in the wind (the default), or a sheet let go that hangs by two corners."),
    ] = None,
    mesh: Annotated[
        Path | None, typer.Option(help="A mesh of yours instead; the scene names it from its own folder.")
    ] = None,
    up: Annotated[
        Up | None, typer.Option(help="Which axis points up in the mesh; Blender has z, glTF y. Default: z.")
    ] = None,
) -> None:
    """Write a scene that runs as it is, with a comment on every field."""
    path = Path(name) if name.endswith(".toml") else Path(f"{name}.toml")
    _check(name, path, kind, mesh, up)
    with expected_errors():
        from taut.output import whole_file
        from taut.scene import Scene
        from taut.scene.shipped import is_shipped
        from taut.scene.template import commented
        from taut.simulation import Simulation

        document = _document(path, kind, mesh, up)
        scene = Scene(document, folder=path.parent)
        warn(Simulation(scene, threads=1).warnings)
        text = commented(scene, document, path.stem)
        with whole_file(path, overwrite=False) as part:
            part.write_text(text, encoding="utf-8")
    if is_shipped(path.stem):
        warn([f"without .toml, {path.stem} is the scene that comes with taut"])
    typer.echo(f"wrote {path}; next: taut run {path}")


def _check(name: str, path: Path, kind: Kind | None, mesh: Path | None, up: Up | None) -> None:
    """Refuse what cannot be meant."""
    if not Path(name).name.strip(".") or not name.isprintable():
        raise fail(f"NAME = {name!r}: is no name for a scene; try my-flag", BAD_INPUT)
    if os.path.lexists(path):
        raise fail(f"{path} exists already, and nothing is overwritten; choose another name", BAD_INPUT)
    if not path.parent.is_dir():
        raise fail(f"there is no folder {path.parent} to write {path.name} to; make it first", BAD_INPUT)
    if mesh is not None and kind is not None:
        raise fail(f"--kind {kind} brings its own cloth and --mesh another; give one of them", BAD_INPUT)
    if mesh is None and up is not None:
        raise fail(f"--up {up} says how a mesh stands; give the mesh with --mesh, too", BAD_INPUT)


def _document(path: Path, kind: Kind | None, mesh: Path | None, up: Up | None) -> dict[str, Any]:
    """The fields that the new scene sets."""
    from taut.scene.starter import KINDS, around_mesh

    title = path.stem.replace("-", " ").replace("_", " ")
    title = title[:1].upper() + title[1:]
    if mesh is None:
        return KINDS[kind or Kind.FLAG](title)
    inside = mesh.resolve().is_relative_to(path.parent.resolve())
    given = mesh if mesh.is_absolute() and not inside else Path(os.path.relpath(mesh, path.parent))
    return around_mesh(title, given.as_posix(), path.parent, up or Up.Z)
