"""Damaged mesh files of every format that taut reads."""

from __future__ import annotations

from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import ClassVar

from tests.attack.frame import Attack, Case, Outcome
from tests.attack.meshes import FORMATS, judge, mutants


class MeshFiles(Attack):
    """Bytes of small files are changed, cut, repeated and joined; numbers and JSON entries are replaced."""

    name: ClassVar[str] = "meshes"
    promise: ClassVar[str] = "damaged mesh files: read as a mesh, or refused in taut's own words"
    short: ClassVar[int] = 100

    def generate(self, random: Random) -> Case:
        extension = random.choice(sorted(FORMATS))
        return {"extension": extension, "content": next(mutants(extension, random.getrandbits(31), 1))}

    def judge(self, case: Case) -> Outcome:
        with TemporaryDirectory() as folder:
            path = Path(folder) / f"mesh.{case['extension']}"
            path.write_bytes(case["content"])
            try:
                said = judge(path)
            except AssertionError as error:
                return Outcome(failure=str(error).replace(folder, "")[:400])
        return Outcome(refused=said is not None)

    def files(self, case: Case) -> dict[str, bytes]:
        return {f"mesh.{case['extension']}": case["content"]}
