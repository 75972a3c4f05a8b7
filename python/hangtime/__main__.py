"""The command line, as the program ``hangtime``, and by ``python -m hangtime``."""

import sys

from ._core import run


def main() -> None:
    """Runs one command and ends the program with its exit status."""
    sys.exit(run(["hangtime", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
