"""Scene files with mistakes in their text."""

from __future__ import annotations

import json
import re
import unicodedata
from pathlib import Path
from random import Random
from typing import ClassVar

from taut import Scene, SceneError, _taut
from taut.scene import find_scene, shipped_scenes

from tests.attack.edits import edit, edited
from tests.attack.frame import Attack, Case, Outcome

WORDS = ["nan", "inf", "-inf", "1e400", "-0", "0", "1e-320", "3.4e38", "1e-45", "9" * 22, "true", '""', "''"]
WORDS += ["[]", "{}", "[[]]", "=", ".", ",", "]", "}", '"', "[[cloth]]", "[solver]", "cloth=", '"x"', "#"]
WORDS += ["\n", "\\ud800", "\\u0000", "\x1b[2J", "é", "\ufeff", "w" * 5000]
LONGEST = 1500
"""Letters of an error [1]."""
FOREIGN = re.compile(
    r"Traceback|object at 0x|line \d+ column \d+ \(char|NoneType|KeyError|struct\.error|RuntimeError"
)
"""What an error of taut's own does not say."""


class Texts(Attack):
    """TOML and JSON, mutated byte by byte and word by word."""

    name: ClassVar[str] = "texts"
    promise: ClassVar[str] = (
        "bytes of scene files: an error of taut's own, or a scene that reads the same again"
    )
    short: ClassVar[int] = 400

    def generate(self, random: Random) -> Case:
        """A shipped scene with some mistakes."""
        words = [word.encode() for word in WORDS]
        edits = [edit(random, words) for _ in range(random.choice([1, 1, 2, 3, 8]))]
        scene = random.choice([scene.name for scene in shipped_scenes()])
        return {"scene": scene, "json": random.random() < 0.4, "edits": edits}

    def judge(self, case: Case) -> Outcome:
        """Read it."""
        text = self._text(case)
        try:
            if case["json"]:
                try:
                    resolved = _taut.resolve_scene(text.decode())[0]
                except UnicodeDecodeError:
                    return Outcome(refused=True)
            else:
                Path("scene.toml").write_bytes(text)
                resolved = Scene.load("scene.toml").to_json()
        except SceneError as error:
            told = str(error)
            if len(told) > LONGEST or not _is_text(told) or FOREIGN.search(told):
                return Outcome(
                    f"the error is {len(told)} letters long, or not one of taut's own: {told[:300]!r}"
                )
            return Outcome(refused=True)
        again = _taut.resolve_scene(resolved)[0]
        return Outcome(
            "" if json.loads(again) == json.loads(resolved) else "a resolved scene reads otherwise"
        )

    def files(self, case: Case) -> dict[str, bytes]:
        """The text."""
        return {"scene.json" if case["json"] else "scene.toml": self._text(case)}

    def _text(self, case: Case) -> bytes:
        path = find_scene(case["scene"])
        given = Scene.load(path).to_json().encode() if case["json"] else path.read_bytes()
        return edited(given, case["edits"])


def _is_text(told: str) -> bool:
    """Whether a text has neither controls nor lone surrogates; what Unicode added lately is no fault."""
    return not any(unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp") for letter in told)
