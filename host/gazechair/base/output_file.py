"""Files that a command writes for a person. Those of the daemon: state_folder.py."""

from __future__ import annotations

import os
from pathlib import Path

from gazechair.base.state_folder import write_whole
from gazechair.base.user_error import UserError


def write_output(path: Path, content: bytes) -> None:
    """Replace the file as a whole; who may read it, and the folders made for it, is for the umask.

    UserError, with everything as it was, for a folder in its place and where nothing can be
    written.
    """
    try:
        if path.exists() and not path.is_file():  # a pipe, as /dev/stdout; a folder is refused
            path.write_bytes(content)
            return
        real = Path(os.path.realpath(path))
        real.parent.mkdir(parents=True, exist_ok=True)
        write_whole(real.with_name(f".{real.name}.new"), real, content)
    except OSError as error:
        raise UserError(f"{path} can't be written: {error.strerror}") from None
