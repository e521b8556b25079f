"""`make docs`: builds the documents as a site, in out/site or the folder named; warnings are errors."""

import logging
import os
import sys
from pathlib import Path

from sphinx.cmd.build import build_main

ROOT = Path(__file__).resolve().parent.parent.parent


def main() -> int:
    """Build everything anew; returns the exit status."""
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "out" / "site"
    _quieten()
    settings = ["-c", ROOT / "tools" / "site", "-d", out.with_name(f"{out.name}-doctrees")]
    options = ["--fail-on-warning", "--keep-going", "--fresh-env", "--write-all", "--quiet"]
    return build_main([*options, *map(str, (*settings, ROOT / "docs", out))])


def _quieten() -> None:
    """Let only the build print, and keep the notebook apart from the user's own IPython."""
    settings = ROOT / "out" / "ipython" / "profile_default"
    settings.mkdir(parents=True, exist_ok=True)
    (settings / "ipython_kernel_config.py").write_text('get_config().IPKernelApp.log_level = "ERROR"\n')
    os.environ["IPYTHONDIR"] = str(settings.parent)
    logging.getLogger("traitlets").setLevel(logging.WARNING)


if __name__ == "__main__":
    sys.exit(main())
