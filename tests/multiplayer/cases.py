"""All ways to make PettingZoo's Atari environments, and a digest of a game in each.

python tests/multiplayer/cases.py ROMS > tests/multiplayer/goldens.json

writes the digests of PettingZoo with Multi-Agent-ALE, which must be installed; ROMS is a folder with the ROM files.
"""

import hashlib
import importlib
import itertools
import json
import random
import sys
import warnings
from collections.abc import Iterator
from typing import Any

from atari.games.pettingzoo import ENVIRONMENTS

STEPS = 150
_CHOICES: dict[str, tuple[Any, ...]] = {
    "combat_plane.game_version": ("bi-plane", "jet"),
    "maze_craze.game_version": ("race", "robbers", "capture"),
    "pong.game_version": (
        "classic", "two_paddles", "soccer", "foozpong", "hockey", "quadrapong", "handball", "volleyball", "basketball"
    ),
    "num_players": (2, 4),
    "visibilty_level": (0, 1, 2, 3),
}  # fmt: skip


def cases() -> Iterator[tuple[str, dict[str, Any]]]:
    """Every environment with every combination of its own parameters, each with other common arguments."""
    number = 0
    for environment in ENVIRONMENTS.values():
        names = list(environment.defaults)
        values = [_CHOICES.get(f"{environment.name}.{name}", _CHOICES.get(name, (False, True))) for name in names]
        for chosen in itertools.product(*values):
            arguments = dict(zip(names, chosen, strict=True))
            if environment.name == "pong" and arguments == {"num_players": 2, "game_version": "quadrapong"}:
                continue  # for four players alone
            number += 1
            yield (
                environment.id,
                {
                    **arguments,
                    "obs_type": ("rgb_image", "grayscale_image", "ram")[number % 3],
                    "full_action_space": number % 2 == 1,
                    "max_cycles": 100 if number % 5 == 0 else 100_000,
                },
            )


def digest(env: Any, seed: int, steps: int = STEPS) -> str:
    """Plays random actions, seeded, over several games; the hash of all that the agents are given."""
    source, seen = random.Random(seed), hashlib.sha256()
    observations, infos = env.reset(seed=seed)
    actions: dict[str, int] = {}
    for step in range(steps):
        for agent, observation in observations.items():
            seen.update(f"{agent} {observation.shape} {observation.dtype}".encode())
            seen.update(observation.tobytes())
        if not env.agents:
            observations, infos = env.reset()
            continue
        if step % 4 == 0:
            actions = {agent: source.randrange(env.action_space(agent).n) for agent in env.possible_agents}
        observations, *rest, infos = env.step({agent: actions[agent] for agent in env.agents})
        numbers = [{agent: int(value) for agent, value in part.items()} for part in rest]
        seen.update(repr((numbers, infos, env.agents)).encode())
    return seen.hexdigest()


def main(roms: str) -> None:
    """Write the digests of PettingZoo."""
    warnings.simplefilter("ignore")
    digests = {}
    for number, (name, arguments) in enumerate(cases()):
        module = importlib.import_module(f"pettingzoo.atari.{name}")
        env = module.parallel_env(auto_rom_install_path=roms, **arguments)
        digests[f"{name} {json.dumps(arguments)}"] = digest(env, number + 1)
        env.close()
    json.dump(digests, sys.stdout, indent=0)
    print()


if __name__ == "__main__":
    main(sys.argv[1])
