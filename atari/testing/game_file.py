"""`check_game_file`: the contract of game definitions, for authors of a cartridge's file."""

import random
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

import atari._emulator as _emulator
from atari.cores import NativeCore, PlainCore
from atari.games.game import Game, RamLabel, load_game
from atari.games.labels import compile_label
from atari.testing.contract import ContractError, broken_by, require, require_same
from atari.testing.core_play import play, some_actions, visible

_PART = 60
"""Steps in each mode and each difficulty."""
_HELD = 600
"""Frames for which each action is held, to check whether actions have effects."""


def check_game_file(
    file: str | PathLike[str] | Game, *, rom: str | PathLike[str] | None = None, steps: int = 2000
) -> None:
    """Check a game definition: its content, and the rules and names of RAM bytes in random play.

    The file is read like in `atari.AtariEnv`. The game is played with random actions, on the native core and on the
    reference core, which must agree in each frame, in all its modes and difficulties. A reset must begin a game, an
    action must have an effect, lives are 0 or more, and a change of a byte named as score must change the reward. Bytes
    named as positions must be on the screen at times. Rules for several players are read, but not played.

    Args:
        file: the path of a game definition, or a `Game`.
        rom: path of the ROM file; None searches beside the file, then like `atari.roms.find`.
        steps: number of frames in the mode with which a game begins.

    Raises:
        ContractError: the file is no game definition, or the game breaks the contract; the message has the key, and the
            expected and the actual result.
        ValueError: the game has only rules for several players.
        FileNotFoundError: there is no such file, or no ROM file.

    Example:
        >>> import atari
        >>> from atari.testing import check_game_file
        >>> check_game_file(atari.games["pong"], steps=200)
    """
    game = file if isinstance(file, Game) else _load(Path(file))
    if game.rules is None:
        raise ValueError(f"{game.id} has no rules of one player, and check_game_file plays no others")
    options: dict[str, Any] = {"rom": rom, "repeat_action_probability": 0.0}
    _check_beginning(game, options)
    _check_modes(game, options)
    _check_actions_matter(game, options)
    _check_play(game, options, steps)


def _load(path: Path) -> Game:
    try:
        return load_game(path)
    except ValueError as error:
        raise ContractError(str(error)) from error


def _check_beginning(game: Game, options: dict[str, Any]) -> None:
    with broken_by(f"a reset of {game.id}"):
        core = NativeCore(game, **options)
        core.reset()
    require(not core.game_over, "[rules] terminal must be 0 when a game begins, but the game is over after the reset")


def _check_modes(game: Game, options: dict[str, Any]) -> None:
    """Check that each mode and difficulty can be selected, and plays the same on both cores."""
    assert game.rules is not None
    require(
        len(game.modes) == 1 or game.rules.mode_select,
        f"[settings] has {len(game.modes)} modes, and [rules] needs mode_select, which selects them at a reset",
    )
    chosen: list[dict[str, Any]] = [{"mode": mode} for mode in game.modes]
    chosen += [{"difficulty": number} for number in game.difficulties]
    for choice in chosen:
        cores = []
        for core_type in (NativeCore, PlainCore):
            with broken_by(f"a reset with {choice} of {game.id}"):
                cores.append(core_type(game, **options, **choice))
                cores[-1].reset()
        _require_same_play(cores, some_actions(cores[0], _PART), f"with {choice}")


def _require_same_play(cores: list[NativeCore], actions: list[int], where: str) -> None:
    native, plain = cores
    for number, action in enumerate(actions, 1):
        (expected,), (seen,) = play(plain, [action]), play(native, [action])
        sentence = f"act({action}), number {number} {where}, must be the same on the native core and the reference core"
        require_same(expected, seen, "the native core", sentence)
        if native.game_over:
            for core in cores:
                core.reset()


def _check_actions_matter(game: Game, options: dict[str, Any]) -> None:
    rams = set()
    for action in game.minimal_actions:
        core = NativeCore(game, **options)
        core.reset()
        for _ in range(_HELD):
            core.act(action)
        rams.add(core.ram().tobytes())
    names = ", ".join(action.name for action in game.minimal_actions)
    matter = len(rams) > 1 or len(game.minimal_actions) == 1
    require(matter, f"[actions] minimal: {names} lead to the same RAM after {_HELD} frames; no action matters")


def _check_play(game: Game, options: dict[str, Any], steps: int) -> None:
    cores = [core_type(game, **options) for core_type in (NativeCore, PlainCore)]
    for core in cores:
        core.reset()
    rams, paid, draw = [], 0, random.Random(0)
    action = 0
    for frame in range(1, steps + 1):
        if frame % 8 == 1:
            action = int(draw.choice(game.minimal_actions))
        rewards = [core.act(action) for core in cores]
        native = cores[0]
        where = f"after frame {frame} of random play"
        require(rewards[0] == rewards[1], f"reward {where} is {rewards[0]}, and {rewards[1]} on the reference core")
        require(native.lives >= 0, f"[rules] lives must be 0 or more, got {native.lives} {where}")
        rams.append(native.ram())
        paid += abs(rewards[0])
        if native.game_over or frame == steps:
            require_same(visible(cores[1]), visible(native), "the native core", f"both cores must be the same {where}")
            for core in cores:
                core.reset()
            require(not native.game_over, f"a reset must begin a game, but the game is over after a reset {where}")
    _check_labels(game, np.array(rams), paid)


def _check_labels(game: Game, rams: Any, paid: int) -> None:
    labels = list(game.ram_labels.values())
    for label in labels:
        with broken_by(f"[ram] {label.name}"):
            compiled = _emulator.Labels([compile_label(label)])
        values, visible = np.empty((1, len(rams)), np.int32), np.empty((1, len(rams)), np.bool_)
        compiled.evaluate(rams, values, visible)
        _check_label(game, label, np.unique(values[visible]).tolist(), paid)


def _check_label(game: Game, label: RamLabel, seen: list[int], paid: int) -> None:
    """Check the values that a label had in play."""
    if len(seen) < 2:
        return
    name, between = f"[ram] {label.name}", f"{seen[0]}..{seen[-1]}"
    if label.kind == "score":
        require(paid, f"{name} is a score and had the values {between}, but [rules] reward was always 0")
    if label.kind in ("position_x", "position_y"):
        size = game.screen.width if label.kind == "position_x" else game.screen.height
        shown = any(0 <= value < size for value in seen)
        require(shown, f"{name} is a {label.kind} and must be within 0..{size - 1} at times, got {between}")
