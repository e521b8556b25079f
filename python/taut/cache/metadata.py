"""The ``zarr.json`` of a cache's group: it names every array, and carries a checksum of itself."""

import hashlib
import json
from pathlib import Path
from typing import Any

from taut.errors import CacheError

FILE = "zarr.json"

FORMAT = "taut-cache/4"
"""What is written: every chunk is on disk, and the metadata has a checksum."""

TRUSTED = "taut-cache/3"
"""What is read as well, on trust: it has no checksum of its metadata, and chunks of zeros are not on disk."""

CHECKSUM = "checksum"
"""SHA-256 of the rest of the document, an attribute of the group."""

_REMEDY = "delete the cache and run it again"


def encoded(document: dict[str, Any]) -> bytes:
    """The document as it is written, with its checksum."""
    document["attributes"][CHECKSUM] = _checksum(document)
    return json.dumps(document, allow_nan=False).encode()


def read(path: Path) -> dict[str, Any]:
    """The document of the cache at `path`, checked.

    Raises:
        FileNotFoundError: there is no such file.
        NotADirectoryError: `path` is a file itself.
        CacheError: it is damaged, cannot be read, or is that of another format.
    """
    file = path / FILE
    document = _parsed(file)
    attributes = document.get("attributes") if isinstance(document, dict) else None
    found = attributes.get("format") if isinstance(attributes, dict) else None
    if not isinstance(attributes, dict) or found not in (FORMAT, TRUSTED):
        ours = isinstance(found, str) and found.startswith("taut-cache/")
        remedy = (
            f"read it with the taut that wrote it, or {_REMEDY}" if ours else "name one that taut run wrote"
        )
        raise CacheError(
            f"{path} is no cache that this taut reads: its format is {found!r}, not {FORMAT!r}; {remedy}"
        )
    # A run that went on in an older cache leaves a checksum there, too.
    expected = attributes.get(CHECKSUM)
    if (found == FORMAT or expected is not None) and expected != _checksum(document):
        raise CacheError(f"{file} is damaged (it differs from its checksum); {_REMEDY}")
    return dict(document)


def unreadable(file: Path, error: OSError) -> CacheError:
    """What to raise for a file that is there but cannot be read."""
    reason = error.strerror or str(error)
    return CacheError(f"{file} cannot be read ({reason}); see to its disk and permissions")


def _parsed(file: Path) -> Any:
    try:
        if file.exists() and not file.is_file():  # a pipe would be waited for, for ever
            raise CacheError(f"{file} is no file; {_REMEDY}")
        return json.loads(file.read_bytes())
    except (CacheError, FileNotFoundError, NotADirectoryError):
        raise
    except OSError as error:
        raise unreadable(file, error) from None
    except (ValueError, RecursionError) as error:
        raise CacheError(f"{file} is damaged ({error}); {_REMEDY}") from None


def _checksum(document: dict[str, Any]) -> str:
    attributes = {name: value for name, value in document["attributes"].items() if name != CHECKSUM}
    text = json.dumps({**document, "attributes": attributes}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
