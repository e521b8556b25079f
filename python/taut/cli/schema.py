"""``taut schema``."""

import typer


def command() -> None:
    """Print the JSON schema of scenes: every field and its unit."""
    from taut import _taut

    typer.echo(_taut.scene_schema())
