"""Tables and pictures of the documents, put in their places by the tools that make them."""

from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs" / "pictures"
LARGEST = 300_000  # [bytes], of a picture in the repository


def rewrite(page: Path, name: str, text: str) -> None:
    """Put a text between the markers `<!-- name: begin -->` and `<!-- name: end -->` of a page."""
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->"
    head, rest = page.read_text().split(begin)
    page.write_text(head + begin + text.strip() + "\n" + end + rest.split(end)[1])


def keep(picture: Path, name: str, widest: int = 1600) -> None:
    """Put a picture into docs/pictures as a JPEG, at most so many pixels wide and not too large."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    out = PICTURES / f"{name}.jpg"
    with Image.open(picture) as image:
        small = image.convert("RGB")
    small.thumbnail((widest, 10 * widest))
    for quality in (90, 80, 70, 60, 50):
        small.save(out, quality=quality)
        if out.stat().st_size < LARGEST:
            return
    raise SystemExit(f"{out} has {out.stat().st_size} bytes, more than {LARGEST}: make it smaller")
