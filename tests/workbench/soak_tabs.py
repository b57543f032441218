"""100 tabs of one workbench server for a time: each asks, acts and listens as the page does. The
last line is a JSON object of counts. Exit status 1: a wrong answer, a tab that hears nothing, or
memory that grows. tools/soak runs this.
"""

import argparse
import asyncio
import collections
import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import aiohttp
import psutil

ROOT = Path(__file__).resolve().parents[2]
TABS = 100
PAUSE_S = 10.0  # between two requests of a tab, on average
STAY = 50  # requests before a tab is reloaded
GROWTH_KIB = 30_000  # in the second half
FAIR = {200, 409}  # 409: another tab has changed what this one shows
WAIT = aiohttp.ClientTimeout(total=3600)  # s; on a busy machine an answer takes minutes
QUESTIONS = ("all", "step", "candidates", "axes", "stretch")


class Bench:
    """The server, and what its tabs saw. heard: events of each tab; wrong: answers that are not as
    they must be.
    """

    def __init__(self, folder):
        command = [ROOT / "tools/davarlab", "open", "--no-browser", folder / "rec.csv"]
        self.process = subprocess.Popen(command, cwd=folder, text=True, stdout=subprocess.PIPE)
        address = urlsplit(self.process.stdout.readline().strip())
        self.origin, self.token = f"http://{address.netloc}", parse_qs(address.query)["token"][0]
        self.counts, self.wrong, self.end = collections.Counter(), [], 0.0
        self.heard = [0] * TABS

    def memory(self):
        """KiB of the server and its children."""
        server = psutil.Process(self.process.pid)
        return sum(one.memory_info().rss for one in (server, *server.children(True))) >> 10

    async def answered(self, response, what):
        text = await response.text()
        self.counts["requests"] += 1
        if response.status not in FAIR:
            self.wrong.append(f"{what}: {response.status} {text[:200]}")
        return json.loads(text) if response.status == 200 else {}

    async def ask(self, session, what, **given):
        async with session.get(f"{self.origin}/api/{what}", params=given) as response:
            return await self.answered(response, what)

    async def act(self, session, what, **given):
        async with session.post(f"{self.origin}/api/{what}", json=given) as response:
            return await self.answered(response, what)

    async def listen(self, socket, tab):
        async for _ in socket:
            self.heard[tab] += 1
            self.counts["events"] += 1

    async def stay(self, tab, rng):
        """One load of the page: some requests, then it is closed."""
        headers = {"X-Davar-Token": self.token, "Origin": self.origin}
        events = f"{self.origin}/events?token={self.token}"
        async with (
            aiohttp.ClientSession(headers=headers, timeout=WAIT) as session,
            session.ws_connect(events) as socket,
        ):
            listening = asyncio.ensure_future(self.listen(socket, tab))
            for _ in range(STAY):
                await asyncio.sleep(rng.expovariate(1 / PAUSE_S))
                if time.monotonic() > self.end:
                    break
                await self.look(session, rng)
            listening.cancel()
        self.counts["loads"] += 1

    async def look(self, session, rng):
        step = await self.ask(session, "step")
        what = rng.choice(QUESTIONS)
        start = rng.uniform(0, 200)
        given = {"start_s": start, "stop_s": start + 50} if what == "stretch" else {}
        await self.ask(session, what, **given)
        if step and rng.random() < 0.05:
            value = rng.uniform(0.2, 0.4)
            given = {"coefficient_deg_per_sqrt_h": value}
            kind = step["cards"][0]["kind"]
            await self.act(
                session, "set", place=0, kind=kind, parameters=given, state=step["state"]
            )

    async def tab(self, number, seed):
        rng = random.Random(seed * TABS + number)
        while time.monotonic() < self.end:
            await self.stay(number, rng)

    async def watch(self, seconds):
        """Memory, read at 60 moments."""
        found = []
        while time.monotonic() < self.end:
            await asyncio.sleep(seconds / 60)
            found.append(self.memory())
        return found

    async def run(self, seconds, seed):
        self.end = time.monotonic() + seconds
        tabs = [self.tab(number, seed) for number in range(TABS)]
        memory, *_ = await asyncio.gather(self.watch(seconds), *tabs)
        return memory


def recording(path):
    rng = random.Random(1)
    rows = [f"{i / 50:.2f},{rng.gauss(0, 0.05):.6f}" for i in range(15000)]
    path.write_text("\n".join(["time_s,gyro_z_dps", *rows]) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as kept:
        folder = Path(kept)
        recording(folder / "rec.csv")
        bench = Bench(folder)
        try:
            memory = asyncio.run(bench.run(options.seconds, options.seed))
        finally:
            bench.process.send_signal(signal.SIGINT)
            status = bench.process.wait()
    half = len(memory) // 2
    growth = max(memory[half:]) - max(memory[: half or 1])
    faults = bench.wrong[:20]
    faults += [f"memory grew by {growth} KiB: {memory}"] if growth > GROWTH_KIB else []
    faults += [f"{bench.heard.count(0)} tabs heard nothing"] if not all(bench.heard) else []
    faults += [f"the server ended with status {status}"] if status not in (0, 130) else []
    print("\n".join(faults))
    print(json.dumps({**bench.counts, "most KiB": max(memory)}))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
