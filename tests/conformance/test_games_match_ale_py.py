"""The game files agree with ale-py: their facts, and their rules evaluated during play."""

import ast
import hashlib
import random
import struct
from pathlib import Path

import ale_py
import numpy as np
import pytest
from ale_py import ALEInterface, LoggerMode
from rules_interpreter import Interpreter, evaluate

import atari
import atari._emulator as _emulator
from atari.games.game import Game

ROMS = Path(ale_py.__file__).parent / "roms"
GAMES = [game.id for game in atari.games.playable()]
ALEInterface.setLoggerMode(LoggerMode.Error)


@pytest.fixture(scope="module", params=GAMES)
def loaded(request: pytest.FixtureRequest) -> tuple[Game, ALEInterface]:
    """A game and ale-py some frames after loading it."""
    game = atari.games[request.param]
    ale = ALEInterface()
    ale.setInt("random_seed", 1)
    ale.setFloat("repeat_action_probability", 0.0)
    ale.loadROM(ROMS / f"{game.id}.bin")
    for _ in range(150):
        ale.act(0)
    return game, ale


def test_actions(loaded: tuple[Game, ALEInterface]) -> None:
    game, ale = loaded
    assert [action.name for action in game.minimal_actions] == [action.name for action in ale.getMinimalActionSet()]
    assert [action.name for action in game.legal_actions] == [action.name for action in ale.getLegalActionSet()]
    assert [int(action) for action in game.legal_actions] == [action.value for action in ale.getLegalActionSet()]


def test_modes_and_difficulties(loaded: tuple[Game, ALEInterface]) -> None:
    game, ale = loaded
    assert list(game.modes) == ale.getAvailableModes()
    assert list(game.difficulties) == ale.getAvailableDifficulties()
    assert game.default_mode == ale.cloneState().getCurrentMode() == game.modes[0]


def test_screen_size(loaded: tuple[Game, ALEInterface]) -> None:
    game, ale = loaded
    assert game.screen.shape == ale.getScreenDims()


def test_tv_format(loaded: tuple[Game, ALEInterface]) -> None:
    """The colours are those of the TV format and of no other one, unless the screen is black."""
    game, ale = loaded
    index, rgb = ale.getScreen(), ale.getScreenRGB()
    every = ["NTSC", "PAL", "SECAM"]
    formats = [name for name in every if np.array_equal(_emulator.palette(name)[index], rgb)]
    assert formats == ([game.screen.format] if index.any() else every)


def test_ram_labels_of_lives(loaded: tuple[Game, ALEInterface]) -> None:
    """A confirmed label of this kind gives the lives."""
    game, ale = loaded
    ram = ale.getRAM()
    for label in game.ram_labels.values():
        if label.kind == "lives" and label.transform is not None and label.evidence == "confirmed":
            assert evaluate(label.transform, ram, {"v": int(ram[label.index])}, base=0) == ale.lives()


def test_cartridge(loaded: tuple[Game, ALEInterface]) -> None:
    game, ale = loaded
    assert b"Cartridge" + game.rom.cartridge.encode() in ale.cloneState().serialize()


def test_paddles(loaded: tuple[Game, ALEInterface]) -> None:
    """A state of ale-py begins with the positions of the two paddles and ends with the range of their movement."""
    game, ale = loaded
    before = ale.cloneState().serialize()
    assert struct.unpack("<2i", before[-8:]) == (game.controllers.paddle_range or (27450, 790196))
    ale.act(ale_py.Action.RIGHT)
    moved = struct.unpack_from("<2i", ale.cloneState().serialize()) != struct.unpack_from("<2i", before)
    assert moved == game.controllers.paddles


@pytest.mark.parametrize("game", list(atari.games))
def test_rom_hashes(game: str) -> None:
    rom = atari.games[game].rom
    image = (ROMS / f"{game}.bin").read_bytes()
    assert (len(image), hashlib.md5(image).hexdigest()) == (rom.size, rom.md5)
    assert hashlib.sha256(image).hexdigest() == rom.sha256


def test_rules_give_the_reward_lives_and_end_of_every_frame(loaded: tuple[Game, ALEInterface]) -> None:
    """100 frames of play, then 300 more while bytes that the rules read are overwritten, to see rare branches."""
    facts, ale = loaded
    assert facts.rules is not None
    rules = Interpreter(facts.rules)
    rng = random.Random(facts.id)
    numbers = [number for _, source in facts.rules.step for number in numbers_in(source)]
    addresses = [number for number in numbers if 0x80 <= number <= 0xFF] or [0x80]
    values = [0, 1, 0xFF, *(number & 0xFF for number in numbers)]

    ale.reset_game()
    now = rules.reset(ale.getRAM(), facts.default_mode, cartridge_ram(ale, facts))
    for frame in range(400):
        assert (ale.lives(), ale.game_over()) == (now["lives"], now["terminal"]), f"frame {frame}"
        if now["terminal"]:
            ale.reset_game()
            now = rules.reset(ale.getRAM(), facts.default_mode, cartridge_ram(ale, facts))
            continue
        if frame > 100 and frame % 4 == 0:
            for address in rng.choices(addresses, k=rng.choice((1, 1, 2, 3))):
                ale.setRAM(address - 0x80, rng.choice((rng.randrange(256), rng.choice(values))))
        reward = ale.act(rng.choice(facts.minimal_actions))
        now = rules.step(ale.getRAM(), cartridge_ram(ale, facts))
        assert reward == now["reward"], f"frame {frame}"


def numbers_in(source: str) -> list[int]:
    constants = [node.value for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Constant)]
    return [number for number in constants if isinstance(number, int)]


def cartridge_ram(ale: ALEInterface, game: Game) -> bytes:
    """The 128 bytes of RAM on the cartridge, which only the rules of klax read; ale-py shows them in its states."""
    if "xram" not in str(game.rules):
        return bytes(128)
    state = ale.cloneState().serialize()
    bank_and_size = state.index(b"CartridgeF6SC") + len(b"CartridgeF6SC")
    words = struct.unpack_from("<128i", state, bank_and_size + 8)
    return bytes(word & 0xFF for word in words)
