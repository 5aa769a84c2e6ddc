"""The profiles on disk: one JSON file, replaced atomically; a damaged one is kept as a copy."""

from __future__ import annotations

import json
import logging
import secrets
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gazechair.base import json_text
from gazechair.base.health import Health
from gazechair.base.reasons import PROFILES
from gazechair.base.state_file import StateFile
from gazechair.people.profiles.fields import Field, Profile, ProfileRefused, check_whole

FILE_NAME = "profiles.json"
MOST_PROFILES = 16
_DIGITS = 9  # of an id; a longer one was written by hand

log = logging.getLogger(__name__)


class Profiles:
    """Thread-safe. There is always at least one profile, and one is chosen."""

    def __init__(
        self, folder: Path | None, fields: Mapping[str, Field], health: Health | None = None
    ) -> None:
        """`folder`: the state folder, None: in memory only.

        A file that can't be read is kept as a copy when a profile is stored; `health`: degraded
        until then.
        """
        health = health or Health(PROFILES)
        self._file = None if folder is None else StateFile(folder / FILE_NAME, health)
        self._fields = dict(fields)
        self._lock = threading.Lock()
        self._changing = threading.Lock()  # taken while writing to disk; readers do not wait
        self._revision = secrets.randbelow(1 << 30)
        self._profiles: dict[str, Profile] = {}
        self._chosen = ""
        self._kept = False
        if self._file is not None:
            self._read(self._file)
        if not self._profiles:
            self._profiles["1"] = {name: field.default for name, field in self._fields.items()}
        if self._chosen not in self._profiles:
            self._chosen = next(iter(self._profiles))
        numbers = (int(id) for id in self._profiles if id.isdecimal() and len(id) <= _DIGITS)
        self._newest = max(numbers, default=0)

    @property
    def kept(self) -> bool:
        """True if a profile was ever chosen or changed."""
        return self._kept

    @property
    def revision(self) -> int:
        """A number that differs after every change and every start of the host."""
        return self._revision

    def chosen(self) -> Profile:
        """The profile of the present driver."""
        with self._lock:
            return dict(self._profiles[self._chosen])

    def as_json(self) -> dict[str, Any]:
        """What GET /profiles answers."""
        with self._lock:
            return self._as_json()

    def change(self, request: Mapping[str, Any], caretaker: bool) -> dict[str, Any]:
        """Do what POST /profiles requests; returns the new as_json(). Raises ProfileRefused.

        `request` is one of {"choose": id}, {"save": {"id": id, field: value, ...}}, and for the
        caretaker {"create": name} (as the chosen one) and {"delete": id}.
        """
        if len(request) != 1:
            raise ProfileRefused("bad_message", "send one of choose, save, create, delete")
        ((kind, what),) = request.items()
        if kind in ("create", "delete") and not caretaker:
            raise ProfileRefused("not_allowed", f"only the caretaker may {kind} a profile")
        with self._changing:
            profiles, chosen = dict(self._profiles), self._chosen
            if kind == "choose":
                chosen = self._known(what)
            elif kind == "save":
                id, profile = self._saved(what, caretaker)
                profiles[id] = profile
            elif kind == "create":
                id, profile = self._created(what)
                profiles[id] = profile
            elif kind == "delete":
                del profiles[self._known(what)]
                if not profiles:
                    raise ProfileRefused("profile_last", "one profile must remain")
                chosen = chosen if chosen in profiles else next(iter(profiles))
            else:
                raise ProfileRefused("bad_message", f"{kind} is none of choose, save, create")
            if self._file is not None:
                _write(self._file, {"chosen": chosen, "profiles": profiles})
            with self._lock:
                self._profiles, self._chosen = profiles, chosen
                self._revision += 1
                self._kept = True
                return self._as_json()

    def _as_json(self) -> dict[str, Any]:
        return {
            "revision": self._revision,
            "chosen": self._chosen,
            "profiles": [{"id": id, **profile} for id, profile in self._profiles.items()],
            "fields": {name: field.as_json() for name, field in self._fields.items()},
        }

    def _known(self, id: Any) -> str:
        if not isinstance(id, str) or id not in self._profiles:
            raise ProfileRefused("profile_unknown", "there is no profile of that id")
        return id

    def _saved(self, what: Any, caretaker: bool) -> tuple[str, Profile]:
        if not isinstance(what, dict):
            raise ProfileRefused("bad_message", '"save" must be an object')
        id = self._known(what.get("id"))
        profile = dict(self._profiles[id])
        for name, value in what.items():
            if name == "id":
                continue
            if name not in self._fields:
                raise ProfileRefused("profile_value", f"{name} is no field of a profile")
            field = self._fields[name]
            if field.care and not caretaker:
                raise ProfileRefused("not_allowed", f"only the caretaker may change {name}")
            profile[name] = field.accept(name, value)
        check_whole(profile)
        return id, profile

    def _created(self, name: Any) -> tuple[str, Profile]:
        if len(self._profiles) >= MOST_PROFILES:
            raise ProfileRefused("profile_full", f"there are {MOST_PROFILES}; delete one first")
        # Never used before: a page that missed a deletion must not change another profile.
        self._newest += 1
        id = str(self._newest)
        name = self._fields["name"].accept("name", name)
        return id, {**self._profiles[self._chosen], "name": name}

    def _read(self, file: StateFile) -> None:
        try:
            text = file.path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return
        except (OSError, UnicodeDecodeError) as error:
            file.damaged(f"cannot be read ({error}); begins with a new profile")
            return
        try:
            document = json_text.parse(text)
            for id, found in document["profiles"].items():
                self._profiles[id] = self._mended(id, dict(found))
            self._chosen = str(document["chosen"])
            self._kept = True
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            file.damaged(f"damaged ({error!r}); begins with what could be read")

    def _mended(self, id: str, found: Mapping[str, Any]) -> Profile:
        # An older or newer host's profile stays usable: unknown values become defaults.
        profile = {}
        for name, field in self._fields.items():
            try:
                profile[name] = field.accept(name, found[name])
            except (KeyError, ProfileRefused):
                log.warning("profile %s: %s is now %r", id, name, field.default)
                profile[name] = field.default
        try:
            check_whole(profile)
        except ProfileRefused as refusal:
            log.warning("profile %s: %s", id, refusal)
            profile["steer_dwell_ms"] = self._fields["steer_dwell_ms"].low
        return profile


def _write(file: StateFile, document: Mapping[str, Any]) -> None:
    try:
        file.replace(json.dumps(document, ensure_ascii=False, indent=1).encode() + b"\n")
    except OSError as error:
        detail = f"{file.path}: {error.strerror}; is the disk full?"
        log.error("%s", detail)
        raise ProfileRefused("profile_not_stored", detail) from None
