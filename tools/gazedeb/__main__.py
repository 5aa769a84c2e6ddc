"""`tools/deb`: builds the package of this checkout."""

from __future__ import annotations

import os
import subprocess
import sys

from gazedeb.package import build, version_of
from gazesetup import ROOT, NotAvailable


def main() -> int:
    """The exit code: 0 built, 2 cannot build."""
    os.umask(0o022)  # the service's user reads what is packed
    try:
        print(build(version_of(ROOT), ROOT / "build"))
    except (NotAvailable, OSError, subprocess.CalledProcessError) as error:
        print(f"tools/deb: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
