"""``taut scenes``."""

from typing import Annotated

import typer

from taut.cli.console import expected_errors


def _complete(incomplete: str) -> list[tuple[str, str]]:
    from taut.scene import shipped_scenes

    return [(scene.name, scene.title) for scene in shipped_scenes() if scene.name.startswith(incomplete)]


def command(
    name: Annotated[
        str | None,
        typer.Argument(
            help="Print the file of this scene instead.", metavar="NAME", autocompletion=_complete
        ),
    ] = None,
) -> None:
    """List the scenes that come with taut; any of them runs by name."""
    with expected_errors():
        from taut.cli.tables import show
        from taut.scene import find_scene, shipped_scenes

        if name is not None:
            typer.echo(find_scene(name).read_text(encoding="utf-8"), nl=False)
            return
        scenes = shipped_scenes()
        show([(scene.name, scene.description) for scene in scenes])
        first = scenes[0].name
        typer.echo(f"\ntaut run {first} --out {first}.zarr runs one, taut scenes {first} prints its file")
