"""`tools/demo` inside the venv; `gazechair demo` is the same."""

from __future__ import annotations

import argparse
import sys

from gazedemo.command import add_options
from gazedemo.demo import demo


def main() -> int:
    """The exit code of the demo."""
    parser = argparse.ArgumentParser(prog="tools/demo", description="A simulated chair to drive.")
    add_options(parser)
    return demo(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
