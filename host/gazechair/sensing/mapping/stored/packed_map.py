"""Packs a map into one zip file of ROS's format, and reads such a file, also by other programs.

Nothing is unpacked onto the disk, and nothing outside the zip file is read.
"""

from __future__ import annotations

import errno
import io
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import PurePosixPath

from gazechair.base import json_text
from gazechair.sensing.mapping.stored import ros_map
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.places import EditRefused, name_of
from gazechair.sensing.mapping.stored.ros_map import PLACES, RosMapError

MOST_BYTES = 5_000_000  # of the zip file; the largest image fits in without being compressed
_MOST_CELLS = 4 << 20
_MOST_TEXT = 256 << 10  # bytes of a file that is no image
_MOST_IMAGE = _MOST_CELLS + (4 << 10)  # bytes
_MOST_WHOLE = _MOST_IMAGE + 2 * _MOST_TEXT  # bytes of all files: image, yaml, places
_MOST_TABLE = 4 << 10  # bytes of the zip file's directory
_YAML = ".yaml", ".yml"
_END = struct.Struct("<4s4H2LH")  # of the last record of a zip file
_END_64_BYTES = 20  # of the record before it in a zip file of more than 4 GB
_PACKING = zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED
_ENCRYPTED = 1
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, struct.error, ValueError, OverflowError),
    *(OSError, EOFError, RuntimeError, NotImplementedError, IndexError, KeyError),
)


def pack(home: HomeMap) -> bytes:
    """A zip file of what ros_map.write writes."""
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in ros_map.files_of(home).items():
            archive.writestr(name, content)
    return whole.getvalue()


def unpack(data: bytes) -> HomeMap:
    """The map in a zip file; its name is what `pack` wrote, else its yaml file's.

    Raises RosMapError.
    """
    files = _files(data)
    yamls = [name for name in files if name.endswith(_YAML)]
    if len(yamls) != 1:
        raise RosMapError("map_file_yaml", f"there are {len(yamls)} files *.yaml, not 1")

    def beside(name: str) -> bytes:
        found = files.get(PurePosixPath(name).name)
        if found is None:
            raise FileNotFoundError(errno.ENOENT, "it is not in the zip file", name)
        return found

    home = ros_map.home_of(files[yamls[0]], beside, yamls[0], "", _MOST_CELLS)
    return HomeMap(_name(files, yamls[0]), home.grid, drawn=home.drawn)


def _name(files: Mapping[str, bytes], yaml: str) -> str:
    """Any name is accepted: it can be changed on the page."""
    stored_name = json_text.parse(files[PLACES]).get("name") if PLACES in files else None
    for name in (stored_name, PurePosixPath(yaml).stem):
        try:
            return name_of(name)
        except EditRefused:
            continue
    return "map"


def _files(data: bytes) -> dict[str, bytes]:
    """Contents of the zip file by file name without folders."""
    if len(data) > MOST_BYTES:
        raise RosMapError("map_file_large", f"{len(data)} bytes are too many")
    try:
        _check_table(data)
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            rows: dict[str, zipfile.ZipInfo] = {}
            for one in archive.infolist():
                name = _plain(one.filename)
                if not name:
                    continue
                if name in rows:
                    raise ValueError(f"{name!r} is in it twice")
                rows[name] = one
            whole = sum(one.file_size for one in rows.values())
            if whole > _MOST_WHOLE:
                raise RosMapError("map_file_large", f"{whole} bytes are too many")
            return {name: _content(archive, one, name) for name, one in rows.items()}
    except _DAMAGE as error:
        raise RosMapError("map_file_zip", f"no zip file that can be used: {error}") from None


def _check_table(data: bytes) -> None:
    """Bounds the directory, as zipfile makes an object of each row before they can be counted."""
    record = _END.unpack(data[-_END.size :])
    if record[0] != b"PK\5\6" or record[-1]:
        raise ValueError("it does not end as one")
    if data[-_END.size - _END_64_BYTES :][:4] == b"PK\6\7" or record[5] > _MOST_TABLE:
        raise ValueError("there is too much in it")


def _plain(path: str) -> str:
    """The file's name without folders; "": not the map's, but added by some operating system."""
    parts = PurePosixPath(path).parts
    if path.startswith("/") or ".." in parts or "\\" in path:
        raise ValueError(f"{path!r} names a file elsewhere")
    if path.endswith("/") or not parts or any(one.startswith((".", "__")) for one in parts):
        return ""
    return parts[-1]


def _content(archive: zipfile.ZipFile, one: zipfile.ZipInfo, name: str) -> bytes:
    most = _MOST_TEXT if name.endswith((*_YAML, ".json")) else _MOST_IMAGE
    if one.compress_type not in _PACKING or one.flag_bits & _ENCRYPTED:
        raise ValueError(f"{name!r} is packed in another way")
    if one.file_size > most:
        raise RosMapError("map_file_large", f"{name!r} is too large ({one.file_size} bytes)")
    with archive.open(one) as file:
        return file.read(most)
