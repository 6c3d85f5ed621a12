"""The program ``inbye``, also as ``python -m inbye``."""

import os
import signal
import sys
from typing import NoReturn

from inbye._native import run_program


def main() -> NoReturn:
    """Run the program with the arguments of this process."""
    # Python's handler would only note Ctrl-C.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Mesa's device selection looks for a display server, and complains where there is none.
    if "XDG_RUNTIME_DIR" not in os.environ:
        os.environ.setdefault("NODEVICE_SELECT", "1")
    run_program([sys.executable, "-m", "inbye"], sys.argv[1:])


if __name__ == "__main__":
    main()
