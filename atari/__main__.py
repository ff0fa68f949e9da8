"""`python -m atari` is the command line `atari`."""

import sys

from atari.cli import main

if __name__ == "__main__":
    sys.exit(main())
