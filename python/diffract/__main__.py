"""The program ``diffract``: ``python -m diffract`` and the command of the wheel."""

import os
import signal
import sys

from diffract import _diffract


def main() -> int:
    """Runs the command line on the words of the process; returns its exit code."""
    # The interpreter would only note the signal, and look at it once the program has ended.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    validates = os.environ.get("DIFFRACT_VALIDATION", "0") not in ("", "0")
    return _diffract.run(["diffract", *sys.argv[1:]], validates)


if __name__ == "__main__":
    sys.exit(main())
