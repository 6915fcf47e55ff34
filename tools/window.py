#!/usr/bin/env python3
"""Takes a picture of the window of diffract on a display of its own.

    tools/window.py OUT.png 'XDOTOOL WORDS' diffract view ARGUMENT...

Starts Xvfb and the command, waits until the window rests, acts on it as the words of xdotool say (`key h`, `mousemove 300 200 click 1`),
waits again, and saves the window. Needs Xvfb, xdotool and Pillow (Debian: xvfb, xdotool, python3-pil).
"""

import os
import struct
import subprocess
import sys
import tempfile
import time

from PIL import Image

# The window rests once it shows its final colours and has not changed for so long [s]; it is given up after PATIENCE [s].
REST = 20
PATIENCE = 600


def screen(folder: str) -> Image.Image:
    """The picture of the display, an XWD dump that Xvfb keeps in memory."""
    data = open(os.path.join(folder, "Xvfb_screen0"), "rb").read()
    head = struct.unpack(">25I", data[:100])
    width, height, stride = head[4], head[5], head[12]
    begin = head[0] + 12 * head[19]
    return Image.frombytes("RGB", (width, height), data[begin : begin + stride * height], "raw", "BGRX", stride)


def is_final(display: dict[str, str]) -> bool:
    """True if the title of the window names no preview and nothing that is being prepared."""
    words = ["xdotool", "search", "--name", "^diffract", "getwindowname"]
    title = subprocess.run(words, env=display, capture_output=True, text=True).stdout
    return title != "" and "preparing" not in title and "(preview)" not in title


def rest(folder: str, display: dict[str, str], size: tuple[int, int]) -> Image.Image:
    """The window, once it has not changed for REST seconds."""
    end = time.monotonic() + PATIENCE
    last, since = None, time.monotonic()
    while time.monotonic() < end:
        now = screen(folder).crop((0, 0, *size))
        if last is None or now.tobytes() != last.tobytes():
            last, since = now, time.monotonic()
        elif time.monotonic() - since > REST and is_final(display):
            return now
        time.sleep(0.5)
    sys.exit("window: it does not come to rest")


def main(target: str, words: str, *command: str) -> None:
    size = (1280, 800)
    with tempfile.TemporaryDirectory() as folder:
        screen_words = ["-screen", "0", f"{size[0]}x{size[1]}x24", "-fbdir", folder, "-nolisten", "tcp"]
        server = subprocess.Popen(["Xvfb", "-displayfd", "1", *screen_words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        number = server.stdout.readline().decode().strip()
        display = {**os.environ, "DISPLAY": f":{number}"}
        display.pop("WAYLAND_DISPLAY", None)
        window = subprocess.Popen(command, env=display)
        try:
            picture = rest(folder, display, size)
            if words:
                # No window manager gives the window the keyboard.
                focus = ["search", "--name", "^diffract", "windowfocus"]
                subprocess.run(["xdotool", *focus, *words.split()], env=display, check=True)
                picture = rest(folder, display, size)
            picture.save(target)
        finally:
            window.terminate()
            window.wait()
            server.terminate()
            server.wait()


if len(sys.argv) < 4:
    sys.exit(__doc__)
main(*sys.argv[1:])
