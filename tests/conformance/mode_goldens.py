"""Check sums of ale-py in every mode and at every difficulty of a game, for `mode_goldens.json`.

`python tests/conformance/mode_goldens.py` writes that file anew, from ale-py alone.
"""

import json
import zlib
from pathlib import Path

import atari
from atari.cores.verify import Run

FILE = Path(__file__).with_suffix(".json")
GAMES = [game.id for game in atari.games.playable()]
ARRAYS = ("ram", "screen", "audio")
NUMBERS = ("lives", "game_over", "truncated", "frame_number", "episode_frame_number")


def runs(game: str) -> list[Run]:
    """Each mode with some difficulty and each difficulty with some mode, through a reset and 60 frames."""
    modes, difficulties = atari.games[game].modes, atari.games[game].difficulties
    return [
        Run(game, 60, seed=i, mode=modes[i % len(modes)], difficulty=difficulties[i % len(difficulties)])
        for i in range(max(len(modes), len(difficulties)))
    ]


def check_sum(run: Run, core_name: str) -> str:
    """The CRC-32 of all that `atari.cores.verify` compares, before the first frame and after every frame."""
    core = run.make(core_name)
    crc, reward, steps = 0, 0, run.steps()
    while True:
        numbers = [int(reward), *(int(getattr(core, name)) for name in NUMBERS)]
        for part in (str(numbers).encode(), *(getattr(core, name)().tobytes() for name in ARRAYS)):
            crc = zlib.crc32(part, crc)
        step = next(steps, None)
        if step is None:
            break
        reward = step.play(core)
    core.close()
    return f"{crc:08x}"


if __name__ == "__main__":
    goldens = {game: [check_sum(run, "ale") for run in runs(game)] for game in GAMES}
    lines = ",\n".join(f'"{game}": {json.dumps(sums)}' for game, sums in goldens.items())
    FILE.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
