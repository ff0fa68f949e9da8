"""Sessions of the inspector for tests, an agent that plays them, and a server."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from inspect import Signature, signature
from typing import Any

from atari.cores import ByteArray
from atari.env import AtariEnv
from atari.games.actions import Action
from atari.lab.inspector.inspection import Inspection

LIVES, PADDLE, SCORE = 57, 72, 77
"""Bytes of Breakout."""


def new_inspection(game: str = "breakout") -> Inspection:
    return Inspection(AtariEnv(game, frameskip=1, repeat_action_probability=0.0, full_action_space=True), seed=0)


class Sweeper:
    """Fires, and moves left and right."""

    name = "sweeper"

    def begin(self, core: object) -> None:
        self.frames = 0

    def act(self, core: object) -> int:
        self.frames += 1
        return int((Action.FIRE, Action.LEFT, Action.NOOP, Action.RIGHT)[self.frames // 16 % 4])


def play(inspection: Inspection, frames: int) -> None:
    inspection.agent = inspection.agent or Sweeper()
    inspection.let_agent_play(True)
    inspection.step(frames)


def ram_at(inspection: Inspection, frame: int) -> ByteArray:
    """The RAM after a frame that is kept."""
    return inspection.main._ram[frame - inspection.main.first]


Use = Callable[[Any, Any], Awaitable[Any]]


def serve(use: Use, game: str = "breakout") -> Any:
    """Run `use` with a served inspection and a client."""
    import aiohttp

    from atari.lab.inspector.server import Inspector

    inspector = Inspector(new_inspection(game))

    async def run() -> None:
        await inspector.start()
        try:
            async with aiohttp.ClientSession() as client:
                await asyncio.wait_for(use(inspector, client), 60)
        finally:
            await asyncio.wait_for(inspector.stop(), 60)

    asyncio.run(run())
    return inspector


def served(test: Callable[..., Awaitable[None]]) -> Callable[..., None]:
    """A test of a served inspection, whose first two arguments are the `Inspector` and a client."""

    def run(**fixtures: Any) -> None:
        serve(lambda inspector, client: test(inspector, client, **fixtures))

    _, _, *others = signature(test).parameters.values()
    run.__name__, run.__doc__ = test.__name__, test.__doc__
    vars(run)["__signature__"] = Signature(others)
    return run


async def receive(tab: Any, wanted: str) -> Any:
    """The next message of a kind: "frame", or a key of a JSON message."""
    import aiohttp

    while True:
        message = await tab.receive()
        assert message.type in (aiohttp.WSMsgType.BINARY, aiohttp.WSMsgType.TEXT), message
        if message.type == aiohttp.WSMsgType.BINARY:
            if wanted == "frame":
                return message.data
        elif wanted in (content := json.loads(message.data)):
            return content[wanted]
