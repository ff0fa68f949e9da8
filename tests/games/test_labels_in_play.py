"""The RAM labels that were measured here, checked against the running game.

All labels of the games in `OPENINGS` are `measured`; for the other games, OCAtari and AtariARI said where to look. Scores and lives must agree with the
rules, positions with the screen: after a change of the byte, the pixels that differ begin and end at the two places.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rules_interpreter import evaluate

import atari
from atari import Action
from atari.cores import NativeCore
from atari.games.game import RamLabel, load_game

OPENINGS = {
    **dict.fromkeys(
        "backgammon blackjack casino crossbow darkchambers flag_capture hangman human_cannonball miniature_golf othello "
        "pitfall2 space_war superman tetris".split(),
        "",
    ),
    **dict.fromkeys("basic_math tic_tac_toe_3d video_checkers video_chess video_cube".split(), "NOOP*60"),
    "earthworld": "FIRE*5 NOOP*60",
    "elevator_action": "NOOP*20",
    "et": "FIRE*20 NOOP*300",
    "journey_escape": "NOOP*30",
    "klax": "NOOP*420",
    "koolaid": "NOOP*700",
    "solaris": "FIRE*60 NOOP*120 FIRE*10 NOOP*120",
    "surround": "UP*20",
    "word_zapper": "FIRE*20 NOOP*300",
}
"""What is played before a check: actions and for how many frames."""

POSITIONS = (
    "entombed", "laser_gates", "lost_luggage", "mr_do", "tutankham", "wizard_of_wor", "zaxxon",
)  # fmt: skip
"""Games that had only score and lives, and for which the place of the player was measured."""

TWO_PLAYERS = ("combat", "joust", "maze_craze", "warlords")
"""Cartridges without single-player rules: with the rules below, one player can move."""

NO_RULES = """
[actions]
minimal = "all"
legal = "all"
starting = ["RESET"]

[settings]
modes = [0]
default_mode = 0
difficulties = [0]

[rules]
lives_initial = 1
state = {}
step = '''
reward   = 0
terminal = 0
lives    = 1
'''
mode_select = []

[ram]
"""

BLINKING = {"tic_tac_toe_3d": 0, "video_checkers": 18, "video_chess": 0}
"""Games whose cursor blinks, and the first row of the board."""

MOVES = {
    "basic_math": {"cursor_x": "RIGHT"},
    "crossbow": {"cursor_x": "RIGHT", "cursor_y": "UP"},
    "darkchambers": {"player_x": "RIGHT"},
    "earthworld": {"player_x": "LEFT", "player_y": "DOWN"},
    "elevator_action": {"player_x": "RIGHT"},
    "et": {"player_x": "LEFT", "player_y": "DOWN"},
    "flag_capture": {"player_x": "RIGHT", "player_y": "DOWN"},
    "journey_escape": {"player_x": "LEFT", "player_y": "UP"},
    "klax": {"player_x": "RIGHT"},
    "koolaid": {"player_x": "RIGHT", "player_y": "DOWN"},
    "miniature_golf": {"player_x": "LEFT", "player_y": "UP"},
    "othello": {"cursor_x": "LEFT", "cursor_y": "UP"},
    "pitfall2": {"player_x": "RIGHT"},
    "solaris": {"player_x": "RIGHT"},
    "superman": {"player_x": "RIGHT", "player_y": "DOWN"},
    "tic_tac_toe_3d": {"cursor_x": "RIGHT", "cursor_y": "DOWN"},
    "video_checkers": {"cursor_x": "UPLEFT", "cursor_y": "UPLEFT"},
    "video_chess": {"cursor_x": "RIGHT", "cursor_y": "UP"},
    "video_cube": {"player_x": "LEFT", "player_y": "UP"},
    "word_zapper": {"player_x": "RIGHT", "player_y": "UP"},
}
"""Labels of the player's positions, and an action that moves them in its direction."""

HELD = {"superman": 60, "video_cube": 9}
"""For how many frames the action is held, where 34 are too few, or reach the other side of the cube."""


def play(core: Any, script: str) -> None:
    for part in script.split():
        name, _, frames = part.partition("*")
        for _ in range(int(frames)):
            core.act(Action[name])


def make(game: str, folder: Path) -> NativeCore:
    """The core of a game, also of a cartridge for two players."""
    options: dict[str, Any] = {"seed": 1, "repeat_action_probability": 0.0}
    if game not in TWO_PLAYERS:
        return NativeCore(game, **options)
    text = (Path(atari.__file__).parent / "games" / "data" / f"{game}.toml").read_text(encoding="utf-8")
    file = folder / f"{game}.toml"
    file.write_text(re.sub(r"players = \d", "players = 1", text).replace("[ram]", NO_RULES, 1), encoding="utf-8")
    return NativeCore(load_game(file), rom=atari.roms.find(game), **options)


@pytest.fixture
def core(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Any]:
    found = make(request.param, tmp_path)
    found.reset()
    yield found
    found.close()


ALL = pytest.mark.parametrize("core", sorted(OPENINGS), indirect=True)


def labels(core: Any) -> dict[str, RamLabel]:
    return dict(core.game.ram_labels)


def value(label: RamLabel, ram: Any) -> int:
    """The value of a label: its transform, without one the byte or its two digits."""
    byte = int(ram[label.index])
    if label.transform is not None:
        return evaluate(label.transform, ram, {"v": byte}, base=0)
    return 10 * (byte >> 4) + (byte & 15) if label.encoding == "bcd" else byte


def visible(label: RamLabel, ram: Any) -> bool:
    return label.visible is None or evaluate(label.visible, ram, {"v": int(ram[label.index])}, base=0) == 1


def score(core: Any) -> int | None:
    """The score that the labels give, or None without such labels."""
    ram, parts = core.ram(), {name: label for name, label in labels(core).items() if label.weight is not None}
    if not parts:
        return None
    sign = {"score_enemy": -1}
    return sum(sign.get(name, 1) * (label.weight or 0) * value(label, ram) for name, label in parts.items())


@ALL
def test_score_and_lives_are_those_of_the_rules(core: Any) -> None:
    """Random actions, then a unit more in each byte of the score."""
    rng = np.random.default_rng(3)
    actions = core.game.minimal_actions
    lives = labels(core).get("lives")
    before = score(core)
    total = 0
    for frame in range(400):
        if frame % 8 == 0:
            action = actions[rng.integers(len(actions))]
        total += core.act(action)
        if core.game_over:
            break
        if before is not None:
            assert score(core) == before + total, frame
        if lives is not None:
            assert value(lives, core.ram()) == core.lives
    core.reset()
    play(core, "NOOP*30")
    state = core.clone_state(include_rng=True)
    for name, label in labels(core).items():
        if label.weight is not None:
            assert paid(core, state, label) == (-label.weight if name == "score_enemy" else label.weight), name


BY_REWARD = {
    game.id: [label for label in game.ram_labels.values() if label.evidence == "confirmed by reward"]
    for game in atari.games.playable()
    if game.id not in OPENINGS
}


@pytest.mark.parametrize("core", [game for game, found in BY_REWARD.items() if found], indirect=True)
def test_digits_that_play_does_not_reach_are_paid(core: Any) -> None:
    play(core, "NOOP*30")
    state = core.clone_state(include_rng=True)
    for label in BY_REWARD[core.game.id]:
        assert paid(core, state, label) == label.weight, label.name


def paid(core: Any, state: Any, label: RamLabel) -> int:
    """How much more reward the next frame pays if the byte is larger by one."""
    rewards = []
    for more in (0, 1):
        core.restore_state(state)
        core.set_ram(label.index, int(core.ram()[label.index]) + more)
        rewards.append(core.act(Action.NOOP))
    return rewards[1] - rewards[0]


def extent(mask: Any, axis: int) -> tuple[int, int]:
    """The first and the last column or row with a pixel that differs."""
    where = np.flatnonzero(mask.any(axis=1 - axis))
    return int(where[0]), int(where[-1])


def difference(core: Any, state: Any, writes: dict[int, int], frames: int, top: int) -> Any:
    """The pixels that differ after these writes: in the first frame with such pixels, of 10 and more frames in all."""
    found = np.zeros(core.screen().shape, bool)
    core.restore_state(state)
    base = []
    for _ in range(frames):
        core.act(Action.NOOP)
        base.append(core.screen())
    core.restore_state(state)
    for index, byte in writes.items():
        core.set_ram(index, byte)
    for screen in base:
        core.act(Action.NOOP)
        found[top:] |= (core.screen() != screen)[top:]
        if frames < 10 and found.any():
            break
    return found


@pytest.mark.parametrize("core", [*sorted(OPENINGS), *POSITIONS, *TWO_PLAYERS], indirect=True)
def test_positions_are_places_on_the_screen(core: Any) -> None:
    """The pixels that differ begin at one place and reach the other, within 3 pixels, unless other things change too."""
    game = core.game.id
    checked = {
        name: label
        for name, label in labels(core).items()
        if label.kind.startswith("position") and label.evidence == "confirmed"
    }
    if not checked:
        pytest.skip("no position was confirmed by a change of its byte")
    frames, top = (40, BLINKING[game]) if game in BLINKING else (8, 0)
    rng = np.random.default_rng(5)
    cases = dict.fromkeys(checked, 0)
    agree = dict.fromkeys(checked, 0)
    opening = OPENINGS.get(game, "NOOP*60")
    play(core, opening)
    for _ in range(16):
        state, ram = core.clone_state(include_rng=True), core.ram()
        for name, label in checked.items():
            axis = 1 if label.kind == "position_x" else 0
            byte = int(ram[label.index])
            for other in rng.integers(36, size=1) if game in BLINKING else (byte + 8, byte - 8, byte + 1):
                changed = ram.copy()
                changed[label.index] = other % 256
                if not (visible(label, ram) and visible(label, changed)):
                    continue
                low, high = sorted((value(label, ram), value(label, changed)))
                if low < 0 or not 4 <= high - low <= 160 or high >= core.screen().shape[1 - axis]:
                    continue
                mask = difference(core, state, {label.index: other % 256}, frames, top)
                if mask.any():
                    first, last = extent(mask, axis)
                    cases[name] += 1
                    agree[name] += abs(first - low) <= 3 and last >= high - 3
        core.restore_state(state)
        action = core.game.minimal_actions[rng.integers(len(core.game.minimal_actions))]
        for _ in range(12):
            core.act(action)
        if core.game_over:
            core.reset()
            play(core, opening)
    assert sum(cases.values()) >= 10
    for name in checked:
        assert agree[name] >= 0.4 * cases[name], (name, agree[name], cases[name])


@pytest.mark.parametrize("core", sorted(MOVES), indirect=True)
def test_the_player_moves_where_the_action_points(core: Any) -> None:
    game = core.game.id
    play(core, OPENINGS[game])
    state = core.clone_state(include_rng=True)
    for name, action in MOVES[game].items():
        label = atari.games[game].ram_labels[name]
        places = []
        for held in ("NOOP", action):
            core.restore_state(state)
            play(core, f"{held}*{HELD.get(game, 34)}")
            ram = core.ram()
            for _ in range(8):  # a byte that several objects share shows the player in some of the frames
                if visible(label, ram):
                    break
                core.act(Action.NOOP)
                ram = core.ram()
            places.append(value(label, ram))
        assert (places[1] > places[0]) == (("RIGHT" if label.kind == "position_x" else "DOWN") in action), (
            name,
            places,
        )
        assert places[0] != places[1], name


@pytest.mark.parametrize("core", ["othello", "tic_tac_toe_3d", "video_checkers", "video_chess"], indirect=True)
def test_squares_are_where_their_names_say(core: Any) -> None:
    """A change of a square's byte changes only pixels of that square; rows and columns are in the order of the screen."""
    play(core, "NOOP*60")
    state = core.clone_state(include_rng=True)
    corners: dict[tuple[int, ...], tuple[int, int]] = {}
    for name, label in core.game.ram_labels.items():
        match = re.fullmatch(r"square((?:_\d)+)", name)
        if not match:
            continue
        mask = np.zeros(core.screen().shape, bool)
        for byte in (0, 1, 16):
            mask |= difference(core, state, {label.index: byte}, 12, 0)
        if not mask.any():
            continue  # under the cursor, which the game draws there
        left, right = extent(mask, 1)
        top, bottom = extent(mask, 0)
        assert right - left < 10, name
        assert bottom - top < 18, name
        place = tuple(int(part) for part in match[1].split("_")[1:])
        corners[place] = (left, top)
    assert len(corners) >= (30 if core.game.id == "video_checkers" else 62)
    for place, (left, top) in corners.items():
        for other, (right, bottom) in corners.items():
            if place[:-2] == other[:-2]:
                assert place[-2] >= other[-2] or top + 4 < bottom, (place, other)
                assert place[-2] != other[-2] or place[-1] >= other[-1] or left < right, (place, other)
