"""The page of an exported material, in notebooks and files."""

from __future__ import annotations

import html
import os
import pathlib
import subprocess
import sys
import tempfile
from typing import Union


class Page:
    """Page that shows a material in a browser with WebGL 2, as `HeightField.show` makes it. A
    notebook shows it as it is.
    """

    def __init__(self, text: str, height: int) -> None:
        self.html = text
        self._height = height

    def save(self, path: Union[str, os.PathLike]) -> None:
        """Writes the page to the file `path`."""
        pathlib.Path(path).write_text(self.html, encoding="utf-8")

    def __repr__(self) -> str:
        return f"Page({len(self.html) / 1e6:.1f} MB of HTML)"

    def _repr_html_(self) -> str:
        frame = f'style="width:100%;height:{int(self._height)}px;border:0"'
        return f'<iframe {frame} srcdoc="{html.escape(self.html)}"></iframe>'


def made(field, name, options, height) -> Page:
    """Returns the page of `field`, called `name`, by the command line with these `options`."""
    with tempfile.TemporaryDirectory() as folder:
        surface, page = os.path.join(folder, f"{name}.gwy"), os.path.join(folder, "page.html")
        field.save(surface)
        command = [sys.executable, "-m", "diffract", "--quiet", "export", surface, "--html", page, *options]
        # The package itself may stand beside the working folder, as in a clone.
        places = [str(pathlib.Path(__file__).parent.parent), os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, places))}
        ran = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        if ran.returncode != 0:
            raise ValueError(ran.stderr.strip().removeprefix("diffract: ") or "the export has failed")
        return Page(pathlib.Path(page).read_text(encoding="utf-8"), height)
