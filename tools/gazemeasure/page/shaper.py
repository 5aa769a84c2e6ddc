"""A slow network in user space: a TCP proxy on loopback with a rate, a delay and a bounded buffer.

One token bucket (here: the time at which the line is free again) and one FIFO buffer per direction,
shared by all connections, as on a radio link. The delay is added after the line, per direction.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from dataclasses import dataclass, field

_PACKET = 1460  # bytes sent at once, so that connections take turns
_BUFFER = 64 * 1024
_SOCKET_BUFFER = 8192  # the kernel's own buffers would be a second, hidden queue
_READY_S = 10.0


@dataclass
class Line:
    """One direction."""

    rate_b_s: float
    delay_s: float
    free_s: float = 0.0
    waiting: int = 0
    most_waiting: int = 0
    carried: int = 0
    room: asyncio.Condition = field(default_factory=asyncio.Condition)

    async def send(self, size: int) -> float:
        """Take `size` bytes as soon as the buffer has room; returns their arrival, loop time."""
        async with self.room:
            await self.room.wait_for(lambda: self.waiting + size <= _BUFFER)
            self.waiting += size
        self.most_waiting = max(self.most_waiting, self.waiting)
        self.carried += size
        loop = asyncio.get_running_loop()
        self.free_s = max(self.free_s, loop.time()) + size / self.rate_b_s
        loop.call_at(self.free_s, self._left, size)
        return self.free_s + self.delay_s

    def _left(self, size: int) -> None:
        self.waiting -= size
        asyncio.get_running_loop().create_task(self._wake())

    async def _wake(self) -> None:
        async with self.room:
            self.room.notify_all()


class Shaper:
    """The proxy in front of `port` on loopback; a context manager. `shape` may change any time."""

    def __init__(self, port: int, mbit_s: float = 1000.0, delay_ms: float = 0.0) -> None:
        self._to = port
        self._rate_b_s = mbit_s * 125_000
        self._delay_s = delay_ms / 1000
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="shaper", daemon=True)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stop: asyncio.Event | None = None
        self._flowing: asyncio.Event | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self.up = Line(self._rate_b_s, self._delay_s)
        self.down = Line(self._rate_b_s, self._delay_s)
        self.port = 0

    def __enter__(self) -> Shaper:
        self._thread.start()
        if not self._ready.wait(_READY_S):
            raise RuntimeError("the shaper does not start")
        return self

    def __exit__(self, *_error: object) -> None:
        assert self._loop is not None
        assert self._stop is not None
        self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(_READY_S)

    def shape(self, mbit_s: float, delay_ms: float) -> None:
        """Set the rate and delay of both directions."""
        for line in (self.up, self.down):
            line.rate_b_s = mbit_s * 125_000
            line.delay_s = delay_ms / 1000

    def drop(self, dropped: bool) -> None:
        """True: queue everything and deliver nothing; False: deliver everything queued."""
        assert self._loop is not None
        assert self._flowing is not None
        act = self._flowing.clear if dropped else self._flowing.set
        self._loop.call_soon_threadsafe(act)

    def _run(self) -> None:
        asyncio.run(self._serve())

    async def _serve(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._stop = asyncio.Event()
        self._flowing = asyncio.Event()
        self._flowing.set()
        listening = socket.create_server(("127.0.0.1", 0))
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _SOCKET_BUFFER)
        server = await asyncio.start_server(self._accept, sock=listening, limit=_PACKET)
        self.port = listening.getsockname()[1]
        self._ready.set()
        await self._stop.wait()
        server.close()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        upstream = socket.socket()
        upstream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _SOCKET_BUFFER)
        upstream.setblocking(False)
        try:
            await asyncio.get_running_loop().sock_connect(upstream, ("127.0.0.1", self._to))
            far_reader, far_writer = await asyncio.open_connection(sock=upstream, limit=_PACKET)
        except OSError:
            upstream.close()
            writer.close()
            return
        for each in (writer, far_writer):
            sock = each.get_extra_info("socket")
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            await asyncio.gather(
                self._carry(reader, far_writer, self.up),
                self._carry(far_reader, writer, self.down),
            )
        finally:
            writer.close()
            far_writer.close()

    async def _carry(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, line: Line
    ) -> None:
        assert self._flowing is not None
        # Bounded by the line's buffer and its delay, and not filled during a drop.
        waiting: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
        deliver = asyncio.create_task(self._deliver(waiting, writer))
        try:
            while data := await reader.read(_PACKET):
                await self._flowing.wait()
                waiting.put_nowait((await line.send(len(data)), data))
            waiting.put_nowait((0.0, b""))
            await deliver
        except (ConnectionError, asyncio.IncompleteReadError):
            writer.close()
        finally:
            deliver.cancel()

    async def _deliver(
        self, waiting: asyncio.Queue[tuple[float, bytes]], writer: asyncio.StreamWriter
    ) -> None:
        loop = asyncio.get_running_loop()
        assert self._flowing is not None
        while True:
            arrives_s, data = await waiting.get()
            await asyncio.sleep(max(0.0, arrives_s - loop.time()))
            await self._flowing.wait()
            if not data:
                with contextlib.suppress(OSError):
                    writer.write_eof()
                return
            writer.write(data)
            await writer.drain()
