"""Follows docs/tutorial.md to the letter: writes files, changes fields, runs commands, expects answers.

`python -m tools.tutorial` does so and makes the tutorial's picture; the tests do so, too.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
TUTORIAL = ROOT / "docs" / "tutorial.md"
PICTURE = ROOT / "docs" / "pictures" / "pennant.jpg"

_BLOCK = re.compile(
    r'^```(\w+)(?: (fails))?(?: title="(.+?)(: change)?")?\n(.*?)^```$', re.MULTILINE | re.DOTALL
)


def follow(folder: Path) -> str:
    """Do everything that the tutorial says, in an empty folder.

    Returns:
        What the commands printed.

    Raises:
        RuntimeError: a command failed, or one did not that should, or none gave the answer that is shown.
    """
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    printed = ""
    for language, fails, file, changes, content in _BLOCK.findall(TUTORIAL.read_text(encoding="utf-8")):
        if changes:
            _change(folder / file, content)
        elif file:
            (folder / file).write_text(content, encoding="utf-8")
        elif language == "sh":
            command = ["bash", "-e", "-c", content]
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
            printed += done.stdout + done.stderr
            if (done.returncode != 0) != bool(fails):
                raise RuntimeError(
                    f"{content}ended with status {done.returncode}:\n{done.stdout}{done.stderr}"
                )
        elif language == "text":
            if content.strip() not in " ".join(printed.split()):
                raise RuntimeError(f"nothing has printed this:\n{content}{printed}")
        else:
            raise RuntimeError(f"a block of {language} has no title, so it is no file:\n{content}")
    return printed


def _change(file: Path, lines: str) -> None:
    """Set fields of a scene file as a reader would: in the line of that name, commented out or not."""
    text = file.read_text(encoding="utf-8")
    for line in lines.splitlines():
        name = line.split(" = ")[0]
        text, found = re.subn(rf"^#?{name} = .*$", line, text, flags=re.MULTILINE)
        if found != 1:
            raise RuntimeError(f"{file.name} has {found} lines to change for {line}")
    file.write_text(text, encoding="utf-8")


def main() -> None:
    """Make the picture."""
    with tempfile.TemporaryDirectory() as folder:
        print(follow(Path(folder)))
        with Image.open(Path(folder) / "both.png") as picture:
            small = picture.convert("RGB").resize((1000, round(1000 * picture.height / picture.width)))
        small.save(PICTURE, quality=85, optimize=True)


if __name__ == "__main__":
    main()
