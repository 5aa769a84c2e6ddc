"""The daemon's side of a child process that reads an inbox (inbox.py)."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from gazechair.base.reasons import PARTS
from gazechair.base.supervisor import Status, Supervised, Supervisor
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox import inbox

_START_S = 60.0


class InboxService(Supervised, ABC):
    """The daemon never waits for it, and driving by hand does not need it."""

    def __init__(self, lidars: tuple[LidarConfig, ...]) -> None:
        """`lidars`: in the order in which their scans are numbered."""
        self._lidars = lidars
        self._writers, self._reader = inbox.open_inbox()

    @property
    def inbox_fd(self) -> int:
        """For Feed."""
        return self._writers.fileno()

    @abstractmethod
    def start(self) -> None:
        """Start the child process."""

    def _supervise(
        self,
        module: str,
        part: str,
        more: Mapping[str, Any],
        fds: tuple[int, ...] = (),
        **options: Any,
    ) -> None:
        """`part`: its name in the health report; `more`: added to the child's argument; `fds`:
        inherited in addition to its inbox; `options`: of its Supervisor."""
        fd = self._reader.fileno()
        lidars = [asdict(config) for config in self._lidars]
        self._supervisor = Supervisor(
            module,
            json.dumps({"lidars": lidars, "fd": fd, **more}),
            self._on_data,
            self._on_status,
            silent_s=PARTS[part].silent_s,
            start_s=_START_S,
            fds=(fd, *fds),
            **options,
        )
        self._supervisor.start()

    def renew(self, lidars: tuple[LidarConfig, ...]) -> None:
        """Restart the child process with other lidars."""
        super().stop()
        self._lidars = lidars
        self.start()

    def stop(self) -> None:
        """End the child process. Nobody may write to its inbox any more."""
        super().stop()
        self._writers.close()
        self._reader.close()

    @abstractmethod
    def _on_data(self, payload: bytes) -> None: ...

    @abstractmethod
    def _on_status(self, status: Status) -> None: ...
