"""The files of the page: read once, known by name; nothing else can be asked for."""

from dataclasses import dataclass
from importlib.resources import files

_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}


@dataclass(frozen=True)
class PageFile:
    """A file and its type."""

    content: bytes
    type: str


def page_files() -> dict[str, PageFile]:
    """Every file of the page by the path under which it is served."""
    found = {}
    for file in (files("taut.view") / "page").iterdir():
        suffix = file.name[file.name.rfind(".") :]
        if suffix in _TYPES:
            found[f"/{file.name}"] = PageFile(file.read_bytes(), _TYPES[suffix])
    found["/"] = found["/index.html"]
    return found
