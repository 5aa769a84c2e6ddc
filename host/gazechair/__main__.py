"""`python -m gazechair` is the command `gazechair`."""

import sys

from gazechair.cli import main

if __name__ == "__main__":
    sys.exit(main())
