"""A network between a browser and a server: bits a second for all together, and the time a packet takes."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_PACKET = 1400  # bytes


class _Direction:
    """What goes one way: packets of all connections, one after the other."""

    def __init__(self, bytes_per_s: float, delay_s: float) -> None:
        self.bytes_per_s = bytes_per_s
        self.delay_s = delay_s
        self._free_s = 0.0

    async def carry(self, source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
        """Pass on what comes until it ends, each packet after the ones before it."""
        loop = asyncio.get_running_loop()
        under_way: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue(64)

        async def arrive() -> None:
            while packet := await under_way.get():
                due_s, data = packet
                await asyncio.sleep(max(0.0, due_s - loop.time()))
                if not data:
                    break
                sink.write(data)
                await sink.drain()
            with suppress(OSError):
                sink.close()

        arriving = asyncio.create_task(arrive())
        with suppress(OSError):
            while data := await source.read(_PACKET):
                self._free_s = max(self._free_s, loop.time()) + len(data) / self.bytes_per_s
                await asyncio.sleep(max(0.0, self._free_s - loop.time()))
                await under_way.put((loop.time() + self.delay_s, data))
        await under_way.put((loop.time() + self.delay_s, b""))
        with suppress(OSError):
            await arriving


@contextmanager
def slow_network(host: str, bits_per_s: float, there_and_back_s: float) -> Iterator[str]:
    """Lead to a server at host:port through a slow network while the context is open; yield its host:port."""
    name, port = host.split(":")
    ready, over = threading.Event(), asyncio.Event()
    found: list[tuple[str, asyncio.AbstractEventLoop]] = []

    async def serve() -> None:
        up, down = (_Direction(bits_per_s / 8.0, there_and_back_s / 2.0) for _ in range(2))

        async def connect(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            await asyncio.sleep(there_and_back_s)  # of TCP
            theirs, ours = await asyncio.open_connection(name, int(port))
            await asyncio.gather(up.carry(reader, ours), down.carry(theirs, writer))

        server = await asyncio.start_server(connect, "127.0.0.1", 0)
        address = server.sockets[0].getsockname()
        found.append((f"{address[0]}:{address[1]}", asyncio.get_running_loop()))
        ready.set()
        await over.wait()
        server.close()

    thread = threading.Thread(target=lambda: asyncio.run(serve()), daemon=True)
    thread.start()
    ready.wait()
    address, loop = found[0]
    try:
        yield address
    finally:
        loop.call_soon_threadsafe(over.set)
        thread.join()
