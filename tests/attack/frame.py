"""What an attack is."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from dataclasses import dataclass
from random import Random
from typing import Any, ClassVar

Case = Any
"""What is tried: numbers, texts, bytes, lists and dicts of them; it can be sent, kept and made smaller."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a case."""

    failure: str = ""
    """What is wrong, in a sentence; empty where the promise held."""
    refused: bool = False
    """Whether taut refused it with an error of its own kind, as it may."""
    looked_at: int = 0
    """How many things were checked, see :attr:`Attack.unit`."""


class Attack(ABC):
    """Makes cases and judges them. It is built anew in every process that runs it."""

    name: ClassVar[str]
    promise: ClassVar[str]
    """What it tries to break, in a few words."""
    unit: ClassVar[str] = ""
    """What :attr:`Outcome.looked_at` counts."""
    seconds: ClassVar[float] = 60.0
    """A case that takes longer has failed [s]."""
    short: ClassVar[int] = 20
    """Cases in the short run of the tests."""

    @abstractmethod
    def generate(self, random: Random) -> Case:
        """Make a case; the same one for the same numbers."""

    @abstractmethod
    def judge(self, case: Case) -> Outcome:
        """Try it. Whatever is raised is a failure as well."""

    def files(self, case: Case) -> dict[str, bytes]:
        """Reproduction files, besides the case itself."""
        return {}


def as_json(case: Case) -> str:
    """A case as text; bytes become `{"hex": ..}`."""
    return json.dumps(case, indent=1, default=lambda value: {"hex": bytes(value).hex()})


def from_json(text: str) -> Case:
    """What :func:`as_json` wrote."""
    return json.loads(
        text, object_hook=lambda found: bytes.fromhex(found["hex"]) if found.keys() == {"hex"} else found
    )
