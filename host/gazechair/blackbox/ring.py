"""A bounded ring of records for the log's process, which never blocks its callers."""

from __future__ import annotations

import logging
import marshal
import socket
from collections import deque
from typing import Any

KEPT = 5000  # records: some 20 s of driving
LONGEST = 1 << 17  # bytes of a batch
_BATCH = 25  # records, so that packing them never blocks for long

Record = tuple[str, int, Any]  # kind, monotonic ns, payload; see topics

log = logging.getLogger(__name__)


class Ring:
    """Any thread puts records in; one hands them over. When full, records are dropped, counted."""

    def __init__(self) -> None:
        self._records: deque[Record] = deque()
        self.dropped = 0

    def __len__(self) -> int:
        return len(self._records)

    def put(self, kind: str, at_s: float, payload: Any) -> None:
        """Add one record of plain values, at monotonic `at_s`. Takes a microsecond."""
        if len(self._records) >= KEPT:
            self.dropped += 1
        else:
            self._records.append((kind, int(at_s * 1e9), payload))

    def hand_over(self, line: socket.socket) -> None:
        """Send as much as `line` takes at once: a non-blocking socket that keeps messages whole."""
        records = self._records
        size = _BATCH
        while records:
            count = min(size, len(records))
            try:
                batch = marshal.dumps([records[at] for at in range(count)])
                if len(batch) > LONGEST and count > 1:
                    size = max(1, size // 4)
                    continue
                if len(batch) > LONGEST:
                    raise ValueError(f"a record of {len(batch)} bytes")
                line.send(batch)
            except BlockingIOError:
                return  # the process does not read: the next time
            except (OSError, ValueError) as error:
                self.dropped += count
                log.debug("not recorded: %s", error)
            for _ in range(count):
                records.popleft()
            size = _BATCH


def unpack(batch: bytes) -> list[Record]:
    """The records of a batch."""
    records: list[Record] = marshal.loads(batch)
    return records
