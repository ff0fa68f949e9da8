"""Plays images with ale-py, which may end its process, so `test_random_programs` runs this file as a separate program.

usage: python reference.py SCRIPT.json RESULT.npz

The script is a list of {"image": hex digits, "actions": [...]}; action -1 is a reset. Images are loaded under the name
of a game with a 4K cartridge, whose rules then determine reward and lives.
"""

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import ale_py
import numpy as np

GAME = "boxing"


def play(image: bytes, actions: list[int]) -> dict[str, np.ndarray]:
    """RAM, screen and audio after loading and after each action."""
    ale = ale_py.ALEInterface()
    ale.setInt("random_seed", 1)
    ale.setFloat("repeat_action_probability", 0.0)
    ale.setBool("sound_obs", True)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{GAME}.bin"
        file.write_bytes(image)
        ale.loadROM(file)
    seen: dict[str, list[np.ndarray]] = {"ram": [], "screen": [], "audio": []}
    for action in [None, *actions]:
        if action == -1:
            ale.reset_game()
        elif action is not None:
            ale.act(action)
        seen["ram"].append(ale.getRAM())
        seen["screen"].append(ale.getScreen())
        seen["audio"].append(ale.getAudio())
    return {name: np.stack(arrays) for name, arrays in seen.items()}


if __name__ == "__main__":
    script, result = map(Path, sys.argv[1:])
    ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)
    results: dict[str, Any] = {}
    for number, entry in enumerate(json.loads(script.read_text())):
        for name, array in play(bytes.fromhex(entry["image"]), entry["actions"]).items():
            results[f"{number} {name}"] = array
    np.savez(result, **results)
