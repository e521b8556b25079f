"""Arguments that several commands take."""

from pathlib import Path
from typing import Annotated

import typer


def complete_scene(incomplete: str) -> list[tuple[str, str]]:
    """What a shell offers for a scene: shipped names with their titles, scene files, folders."""
    from taut.scene import shipped_scenes

    names = [(scene.name, scene.title) for scene in shipped_scenes()]
    prefix = incomplete[: incomplete.rfind("/") + 1]
    here = Path(prefix or ".")
    if here.is_dir():
        for path in sorted(here.iterdir()):
            if path.is_dir() and path.suffix != ".zarr" and not path.name.startswith("."):
                names.append((f"{prefix}{path.name}/", "folder"))
            elif path.suffix == ".toml":
                names.append((f"{prefix}{path.name}", "scene file"))
    return [(name, meaning) for name, meaning in names if name.startswith(incomplete)]


SceneArgument = Annotated[
    Path,
    typer.Argument(
        help="A scene file, or the name of a shipped scene (`taut scenes`).",
        metavar="SCENE",
        autocompletion=complete_scene,
    ),
]

OptionalScene = Annotated[
    Path | None,
    typer.Argument(
        help="A scene file, or the name of a shipped scene (`taut scenes`).",
        metavar="SCENE",
        autocompletion=complete_scene,
        show_default=False,
    ),
]

Yes = Annotated[
    bool, typer.Option("--yes", help="Make a folder for --out that is not there, without a question.")
]

Sandbox = Annotated[
    bool, typer.Option("--sandbox", help="For a scene from elsewhere: read no mesh outside its folder.")
]
