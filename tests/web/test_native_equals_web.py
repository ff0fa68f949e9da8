"""The core in WebAssembly shows what the native core shows: frames, labels, objects, writes, states of either."""

import json
import random
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from web_tools import GAMES, image, needs_core, node, packed, unpacked

import atari
from atari.cores import NativeCore, snapshot
from atari.cores.writes import make_writes, possible_values, write_of
from atari.games.game import Game
from atari.games.interventions import load
from atari.games.objects import positions, visible_objects
from atari.lab.labels import Labels
from atari.web.table import core_text

SINGLE = [name for name in GAMES if atari.games[name].single_player]
Call = list[Any]


def shown(core: NativeCore, reward: int = 0) -> list[Any]:
    """What `shown` of play_calls.mjs returns."""
    sums = [zlib.crc32(part.tobytes()) for part in (core.ram(), core.screen(), core.audio())]
    ends = [core.lives, core.game_over, core.truncated, core.frame_number, core.episode_frame_number]
    return [*sums, reward, *ends, core.mode, core.difficulty]


def random_calls(game: Game, rng: random.Random, frames: int) -> Iterator[Call]:
    """Resets, held actions, changes of the mode and the difficulty, pokes, writes and snapshots."""
    values = {name: sorted(possible_values(game, name)) for name in game.ram_labels}
    labels = [name for name in values if values[name]]
    played = writes = 0
    while played < frames:
        kind = rng.random()
        if kind < 0.03:
            yield ["mode", rng.choice(game.modes)]
            yield ["reset"]
        elif kind < 0.05:
            yield ["difficulty", rng.choice(game.difficulties)]
        elif kind < 0.10:
            yield ["poke", rng.randrange(128), rng.randrange(256)]
        elif kind < 0.14 and writes < 8:
            to = rng.choice(labels) if labels and rng.random() < 0.5 else rng.randrange(128)
            value = rng.choice(values[to]) if isinstance(to, str) else rng.randrange(256)
            when = rng.choice(["frame", "held", [3, 40]])
            yield ["addWrite", json.dumps({"to": to, "value": value, "when": when}), rng.random() < 0.5]
            writes += 1
        elif kind < 0.16 and writes:
            writes -= 1
            yield ["removeWrite", -1]  # the last
        elif kind < 0.22:
            yield ["snapshot"]
        elif kind < 0.25:
            yield ["restore", None]  # the last snapshot
        elif kind < 0.28:
            yield ["ahead", rng.randrange(3), rng.randrange(18)]
        elif kind < 0.30:
            yield ["seed", rng.randrange(2**32)]
            yield ["reset"]
        else:
            action, strength = rng.randrange(18), rng.choice([1, 1, 1, 0.5])
            count = rng.randrange(1, 20)
            played += count
            yield from [["act", action, 0, strength]] * count


def on_native(core: NativeCore, calls: list[Call]) -> list[Any]:
    """Make the calls on the native core, fill in their open arguments, and return the results."""
    results: list[Any] = []
    saved = b""
    added: list[Any] = []
    reward = 0
    for call in calls:
        name, *values = call
        result: Any = None
        if name == "act":
            reward = core.act(values[0], *values[2:])
        elif name == "reset":
            core.reset()
        elif name == "seed":
            core.seed(*values)
        elif name == "mode":
            core.set_mode(*values)
        elif name == "difficulty":
            core.set_difficulty(*values)
        elif name == "poke":
            core.set_ram(*values)
        elif name == "addWrite":
            write = write_of(core.game, values[0])
            before = core.writes
            core.add_write(write, values[1])
            result = next((slot for slot, one in enumerate(before) if one is None), len(before))
            added.append(write)
        elif name == "removeWrite":
            call[1] = core.remove_write(added.pop())
        elif name == "snapshot":
            saved = core.snapshot()
            result = packed(zlib.decompress(snapshot.unpack(saved)[1]["state"]))
        elif name == "restore":
            call[1] = packed(saved)
            core.restore(saved)
        if name in ("act", "reset", "seed", "poke", "restore", "ahead"):
            result = shown(core, reward)
        results.append(result)
    return results


def played_core(game: Game, seed: int, **options: Any) -> tuple[NativeCore, dict[str, Any]]:
    core = NativeCore(game, seed=seed, sound=True, **options)
    names = [one.name for one in core.interventions]
    return core, {"seed": seed, "sound": True, **options, **({"interventions": names} if names else {})}


@needs_core
@pytest.mark.parametrize("name", SINGLE)
def test_calls(name: str) -> None:
    game = atari.games[name]
    rng = random.Random(zlib.crc32(name.encode()))
    known = list(load(game).values())
    chosen = rng.sample(known, min(len(known), 2))
    limit = {"max_num_frames_per_episode": 20_000} if rng.random() < 0.3 else {}
    core, options = played_core(game, rng.randrange(2**32), interventions=chosen, **limit)
    calls = [["reset"], ["snapshot"], *random_calls(game, rng, 400)]
    expected = on_native(core, calls)
    seen = node("play_calls.mjs", core=core_text(game), image=image(name), options=options, calls=calls)
    for i, (call, one, other) in enumerate(zip(calls, expected, seen, strict=True)):
        if call[0] == "snapshot":
            other = packed(zlib.decompress(snapshot.unpack(unpacked(other))[1]["state"]))
        elif call[0] in ("mode", "difficulty", "removeWrite"):
            other = None if other in (1, None) else other
        elif call[0] == "ahead":
            one, other = one[:3] + one[4:], other[1:4] + other[5:]
        elif call[0] in ("reset", "seed", "restore", "poke"):
            one[3], other[3] = 0, 0  # the reward is the last frame's
        assert other == one, f"call {i} of {len(calls)}, {call}: {calls[max(i - 3, 0) : i]}"
    last = max(i for i, call in enumerate(calls) if call[0] == "snapshot")
    core.restore(unpacked(seen[last]))  # a snapshot of the page, on the native core
    assert packed(core.save()) == expected[last]


@needs_core
@pytest.mark.parametrize("name", [name for name in SINGLE if atari.games[name].ram_labels])
def test_labels_and_objects(name: str) -> None:
    game = atari.games[name]
    found = positions(game.ram_labels)
    rng = random.Random(name)
    core, options = played_core(game, 1, repeat_action_probability=0.0)
    calls: list[Call] = [["reset"]]
    core.reset()
    rams = [core.ram().copy()]
    for _ in range(1000):
        if core.game_over:
            calls.append(["reset"])
            core.reset()
        else:
            calls.append(["act", int(rng.choice(game.minimal_actions))])
            core.act(calls[-1][1])
        rams.append(core.ram().copy())
    seen = node(
        "play_calls.mjs",
        core=core_text(game),
        image=image(name),
        options=options,
        calls=calls,
        labels=len(game.ram_labels),
        objects=len(found),
    )
    labels = Labels(game)
    values, visible = labels.evaluate(np.array(rams))
    for i, ((*_, of_labels, of_objects), ram) in enumerate(zip(seen, rams, strict=True)):
        assert of_labels == [int(v) if ok else None for v, ok in zip(values[:, i], visible[:, i], strict=True)]
        places = {one.name: {"x": one.x, "y": one.y} for one in visible_objects(found, labels.values(ram))}
        assert of_objects == [places.get(name) for name in found]


@needs_core
@pytest.mark.parametrize("name", [name for name in SINGLE if load(name)])
def test_writes_of_interventions(name: str) -> None:
    game = atari.games[name]
    core, options = played_core(game, 3)
    calls: list[Call] = []
    for one in load(game).values():
        calls += [["seed", 3], ["reset"]]
        calls += [["addWrite", write.definition, True] for write in make_writes(game, [one])]
        calls += [["act", action % 18] for action in range(60)]
        calls += [["removeWrite", -1] for _ in one.writes]
    expected = on_native(core, calls)
    seen = node("play_calls.mjs", core=core_text(game), image=image(name), options=options, calls=calls)
    for call, one, other in zip(calls, expected, seen, strict=True):
        if call[0] in ("act", "addWrite"):
            assert other == one
