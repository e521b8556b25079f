"""``python -m taut``, the same as ``taut``."""

from taut.cli import main

main()
