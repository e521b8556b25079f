"""The command ``taut``."""

from taut.cli.app import main

__all__ = ["main"]
