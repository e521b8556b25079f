"""``python -m taut.render.probe`` prints what renders here.

It runs in a process of its own, since a bad driver may end it.
"""

import re
import sys

from taut.render.options import RenderError
from taut.render.stage import open_plotter


def renderer() -> str:
    """Render an empty picture and name the OpenGL device that did it.

    Raises:
        RenderError: this machine has no OpenGL, in software or otherwise.
    """
    plotter = open_plotter((1, 1), (64, 64))
    plotter.screenshot(return_img=True)
    window = plotter.render_window
    assert window is not None  # it is open
    found = re.search(r"OpenGL renderer string: *(.+)", window.ReportCapabilities())
    way = type(window).__name__.removeprefix("vtk").removesuffix("RenderWindow").removesuffix("OpenGL")
    plotter.close()
    return f"{found[1].strip() if found else 'OpenGL'} through {way}"


if __name__ == "__main__":
    try:
        print(renderer())
    except RenderError as error:
        sys.exit(str(error))
