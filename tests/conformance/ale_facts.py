"""What ale-py says of a game, beside what the game file says: the facts, and the rules evaluated during play.

Each function answers for one side, "ale" or "native"; `ale_goldens.py` keeps the answers of ale-py.
"""

import ast
import random
import struct
import zlib
from pathlib import Path
from typing import Any

import ale_py
import numpy as np
from rules_interpreter import Interpreter, evaluate

import atari
import atari._emulator as _emulator
from atari.cores import NativeCore
from atari.games.game import Game, RamLabel

ROMS = Path(ale_py.__file__).parent / "roms"
FORMATS = ["NTSC", "PAL", "SECAM"]


def loaded(game: str, **settings: bool) -> Any:
    """ale-py's interface with a game, without sticky actions."""
    ale = ale_py.ALEInterface()
    ale.setInt("random_seed", 1)
    ale.setFloat("repeat_action_probability", 0.0)
    for name, value in settings.items():
        ale.setBool(name, value)
    ale.loadROM(ROMS / f"{game}.bin")
    return ale


def facts(game: str, side: str) -> dict[str, Any]:
    """The facts of a game, and those that are seen after 150 frames."""
    file = atari.games[game]
    machine = loaded(game) if side == "ale" else NativeCore(game, seed=1, repeat_action_probability=0.0)
    for _ in range(150):
        machine.act(0)
    return (_facts_of_ale_py if side == "ale" else _facts_of_file)(file, machine)


def _facts_of_ale_py(game: Game, ale: Any) -> dict[str, Any]:
    """A state begins with the positions of the two paddles and ends with the range of their movement."""
    index, rgb, before = ale.getScreen(), ale.getScreenRGB(), ale.cloneState()
    state = before.serialize()
    place = state.index(b"Cartridge")
    (size,) = struct.unpack_from("<i", state, place - 4)
    lives = ale.lives()
    ale.act(ale_py.Action.RIGHT)
    return {
        "minimal": " ".join(action.name for action in ale.getMinimalActionSet()),
        "legal": [
            " ".join(action.name for action in ale.getLegalActionSet()),
            *[action.value for action in ale.getLegalActionSet()],
        ],
        "modes": [before.getCurrentMode(), *ale.getAvailableModes()],
        "difficulties": list(ale.getAvailableDifficulties()),
        "screen": list(ale.getScreenDims()),
        "formats": [name for name in FORMATS if np.array_equal(_emulator.palette(name)[index], rgb)],
        "lives": [lives for _ in labels_of_lives(game)],
        "cartridge": state[place : place + size].decode(),
        "paddle range": list(struct.unpack("<2i", state[-8:])),
        "paddles": struct.unpack_from("<2i", ale.cloneState().serialize()) != struct.unpack_from("<2i", state),
    }


def _facts_of_file(game: Game, core: NativeCore) -> dict[str, Any]:
    """The colours are those of the TV format and of no other one, unless the screen is black."""
    ram, legal = core.ram(), game.legal_actions
    return {
        "minimal": " ".join(action.name for action in game.minimal_actions),
        "legal": [" ".join(action.name for action in legal), *map(int, legal)],
        "modes": [game.default_mode, *game.modes],
        "difficulties": list(game.difficulties),
        "screen": list(game.screen.shape),
        "formats": [game.screen.format] if core.screen().any() else FORMATS,
        "lives": [
            evaluate(str(label.transform), ram, {"v": int(ram[label.index])}, base=0) for label in labels_of_lives(game)
        ],
        "cartridge": f"Cartridge{game.rom.cartridge}",
        "paddle range": list(game.controllers.paddle_range or (27450, 790196)),
        "paddles": game.controllers.paddles,
    }


def labels_of_lives(game: Game) -> list[RamLabel]:
    """The confirmed labels that give the lives."""
    confirmed = [label for label in game.ram_labels.values() if label.evidence == "confirmed"]
    return [label for label in confirmed if label.kind == "lives" and label.transform is not None]


def rules(game: str, side: str) -> str:
    """The check sum of reward, lives and end of each frame, on our side by the rules of the game file in plain Python.

    These are 100 frames of play, then 300 more while bytes that the rules read are overwritten, to see rare branches.
    """
    file = atari.games[game]
    assert file.rules is not None
    of_ale_py = side == "ale" or "xram" in str(file.rules)  # whose states show the RAM of a cartridge
    machine: Any = loaded(game) if of_ale_py else NativeCore(game, seed=1, repeat_action_probability=0.0)
    ram, begin, poke = (
        (machine.getRAM, machine.reset_game, machine.setRAM)
        if of_ale_py
        else (machine.ram, machine.reset, machine.set_ram)
    )
    interpreter = Interpreter(file.rules)
    rng = random.Random(game)
    numbers = [number for _, source in file.rules.step for number in _numbers_in(source)]
    addresses = [number for number in numbers if 0x80 <= number <= 0xFF] or [0x80]
    values = [0, 1, 0xFF, *(number & 0xFF for number in numbers)]

    def frame(reward: int | None) -> list[int]:
        """Reward, lives and end of the present frame; without a reward the first of a game."""
        if side == "ale":
            return [reward or 0, machine.lives(), machine.game_over()]
        memory = ram(), _cartridge_ram(machine, file)
        if reward is None:
            now = {**interpreter.reset(memory[0], file.default_mode, memory[1]), "reward": 0}
        else:
            now = interpreter.step(*memory)
        return [now["reward"], now["lives"], now["terminal"]]

    begin()
    found, crc = frame(None), 0
    for number in range(400):
        crc = zlib.crc32(str([int(value) for value in found]).encode(), crc)
        if found[2]:
            begin()
            found = frame(None)
            continue
        if number > 100 and number % 4 == 0:
            for address in rng.choices(addresses, k=rng.choice((1, 1, 2, 3))):
                poke(address - 0x80, rng.choice((rng.randrange(256), rng.choice(values))))
        found = frame(machine.act(rng.choice(file.minimal_actions)))
    return f"{crc:08x}"


def _numbers_in(source: str) -> list[int]:
    constants = [node.value for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Constant)]
    return [number for number in constants if isinstance(number, int)]


def _cartridge_ram(ale: Any, game: Game) -> bytes:
    """The 128 bytes of RAM on the cartridge, which only the rules of klax read."""
    if "xram" not in str(game.rules):
        return bytes(128)
    state = ale.cloneState().serialize()
    bank_and_size = state.index(b"CartridgeF6SC") + len(b"CartridgeF6SC")
    words = struct.unpack_from("<128i", state, bank_and_size + 8)
    return bytes(word & 0xFF for word in words)
