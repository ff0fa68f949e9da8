"""Bowling, Hangman, Human Cannonball and 3-D Tic-Tac-Toe for two players, by rules that Multi-Agent-ALE does not have."""

import hashlib
import itertools
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.games.game import Game
from atari.multiplayer import MultiplayerCore

FIRE, UP, RIGHT, DOWN = 1, 2, 3, 5
Actions = Callable[[int], list[int]]


def byte(core: MultiplayerCore, address: int) -> int:
    return int(core.ram()[address - 0x80])


def started(game: Any, mode: int, difficulty: int = 0) -> MultiplayerCore:
    core = MultiplayerCore(game, mode=mode, difficulty=difficulty)
    core.reset()
    assert not core.game_over
    return core


def random_actions(seed: int, hold: int = 8, choices: tuple[int, ...] = (0, 1, 2, 5)) -> Actions:
    """Actions of both players: NOOP, FIRE, UP or DOWN, each held for some frames."""
    source, actions = random.Random(seed), [0, 0]

    def of_frame(frame: int) -> list[int]:
        if frame % hold == 0:
            actions[:] = [source.choice(choices) for _ in range(2)]
        return actions

    return of_frame


def shown(core: MultiplayerCore) -> list[int]:
    """The score of each player, from the digits on the screen, which are binary-coded decimals."""
    places = {"bowling": ((0xA6, 0xA1), (0xA7, 0xA2)), "human_cannonball": ((0xB6,), (0xB7,))}[core.game.id]
    ram = core.ram().tolist()
    return [int("".join(f"{ram[address - 0x80]:02x}" for address in place)) for place in places]


def play(core: MultiplayerCore, actions: Actions, frames: int = 40_000) -> tuple[list[int], int]:
    """The score of each player in a game, and its frames. The rewards are what the screen shows, in each frame."""
    totals = shown(core)
    for frame in range(frames):
        totals = [total + reward for total, reward in zip(totals, core.act_players(actions(frame)), strict=True)]
        assert totals == shown(core)
        if core.game_over:
            return totals, frame + 1
    return totals, frames


def endless(game: str, folder: Path) -> Game:
    """The game with rules in which it never ends."""
    lines = (Path(atari.__file__).parent / f"games/data/{game}.toml").read_text().splitlines()
    start = lines.index("[multiplayer.rules]")
    for number, line in enumerate(lines):
        if number > start and line.startswith("terminal"):
            lines[number] = "terminal = 0"
    path = folder / f"{game}.toml"
    path.write_text("\n".join(lines))
    return atari.games.resolve(str(path))


SCORES = {
    ("bowling", 1): ([21, 22], 17842),
    ("bowling", 3): ([29, 17], 16757),
    ("bowling", 5): ([13, 28], 17650),
    ("human_cannonball", 0): ([7, 5], 16591),
    ("human_cannonball", 1): ([4, 7], 24408),
    ("human_cannonball", 2): ([1, 1], 18_000),
    ("human_cannonball", 3): ([1, 2], 27_000),
    ("human_cannonball", 4): ([1, 0], 24_000),
    ("human_cannonball", 5): ([1, 2], 7_000),
    ("human_cannonball", 6): ([1, 1], 15_000),
    ("human_cannonball", 7): ([0, 0], 12_000),
}
"""By game and mode: the score of each player and the frames; a multiple of 1,000 is none of a whole game."""


@pytest.mark.parametrize(("game", "mode"), SCORES)
def test_a_game_of_random_players_has_this_score(game: str, mode: int) -> None:
    scores, frames = SCORES[game, mode]
    core = started(game, mode)
    assert play(core, random_actions(1), frames) == (scores, frames)
    assert core.game_over == (frames % 1000 > 0)


@pytest.mark.parametrize(("game", "mode"), SCORES)
@pytest.mark.parametrize("idle", [0, 1])
def test_a_player_who_does_nothing_scores_nothing_and_is_waited_for(game: str, mode: int, idle: int) -> None:
    both, core = random_actions(3), started(game, mode)

    def one(frame: int) -> list[int]:
        actions = list(both(frame))
        actions[idle] = 0
        return actions

    totals, frames = play(core, one, 3000)
    assert (totals[idle], frames) == (0, 3000)
    assert idle == 1 or totals == [0, 0]  # player 1 begins


@pytest.mark.parametrize("game", ["bowling", "human_cannonball"])
def test_a_difficulty_switch_is_of_one_player(game: str) -> None:
    if game == "bowling":
        results = [play(started(game, 1, difficulty), random_actions(4))[0] for difficulty in range(4)]
    else:
        results = []
        for difficulty in range(4):
            core = started(game, 0, difficulty)
            widths = []
            for player in range(2):
                while byte(core, 0xB5) != player or byte(core, 0x8F) != 0:
                    core.act_players([FIRE, FIRE])
                core.act_players([0, 0])
                core.act_players([0, 0])
                row = core.screen_grayscale()[140]
                widths.append(int(np.ptp(np.flatnonzero(row == row[130:].min()))))
            results.append(widths)
    first, second = zip(*results, strict=True)
    assert first[0] == first[2] != first[1] == first[3]
    assert second[0] == second[1] != second[2] == second[3]


@pytest.fixture(scope="module")
def tenth_frame() -> bytes:
    """A game of Bowling in which the tenth frame of player 1 begins."""
    core, actions = started("bowling", 3), random_actions(1)
    for frame in itertools.count():
        core.act_players(actions(frame))
        if byte(core, 0xA4) == 0x10:
            return core.snapshot()
    raise AssertionError


@pytest.mark.parametrize(
    ("seed", "counts", "scores"),
    [
        (0, ["0x10", "0x11"], [33, 19]),
        (6, ["0x10", "0x11", "0x10", "0x11"], [45, 17]),  # player 1: a spare, and an extra ball
        (96, ["0x10", "0x11", "0x12", "0x10", "0x11"], [47, 17]),  # player 1: a strike, and two extra balls
        (29, ["0x10", "0x11", "0x12"], [34, 33]),  # player 2: a spare
        (16, ["0x10", "0x11", "0x12", "0x13"], [31, 36]),  # player 2: a strike
    ],
)
def test_a_game_of_bowling_ends_after_the_extra_balls(
    seed: int, counts: list[str], scores: list[int], tenth_frame: bytes, tmp_path: Path
) -> None:
    """0xA4 counts these balls, too; the end of ALE's game of one player is where it passes 0x10."""
    core = MultiplayerCore("bowling", mode=3)
    core.restore(tenth_frame)
    on = MultiplayerCore(endless("bowling", tmp_path), mode=3)
    on.load(core.save())
    actions, seen = random_actions(seed, 6, (1, 2, 2, 5)), [byte(core, 0xA4)]
    totals = shown(core)
    for frame in range(6000):
        chosen = actions(frame)
        paid = on.act_players(chosen)
        if core.game_over:
            assert paid == [0, 0]  # the cartridge plays on without a player
            continue
        assert core.act_players(chosen) == paid
        totals = [total + reward for total, reward in zip(totals, paid, strict=True)]
        seen += [count for count in [byte(core, 0xA4)] if count != seen[-1]]
    assert core.game_over
    assert ([hex(count) for count in seen], totals) == (counts, scores)
    assert shown(on) == scores


@pytest.mark.parametrize(
    ("mode", "seed", "scores"),
    [
        (0, 0, [7, 6]),  # player 1 hits, player 2 misses the last shot
        (1, 0, [6, 7]),
        (1, 5, [7, 7]),  # player 2 answers
    ],
)
def test_player_2_has_the_last_shot_of_human_cannonball(
    mode: int, seed: int, scores: list[int], tmp_path: Path
) -> None:
    core, on = started("human_cannonball", mode), started(endless("human_cannonball", tmp_path), mode)
    for one in (core, on):
        one.act_players([0, 0])
        one.set_ram(0x36, 6)
        one.set_ram(0x37, 6)
        one.act_players([0, 0])
    assert play(core, random_actions(seed))[0] == scores
    assert core.game_over
    assert play(on, random_actions(seed), 9000) == (scores, 9000)  # no shot follows


# 3-D Tic-Tac-Toe: square 16 * board + 4 * row + column.


def lines() -> set[frozenset[int]]:
    found = set()
    for start in itertools.product(range(4), repeat=3):
        for step in itertools.product((-1, 0, 1), repeat=3):
            squares = [tuple(a + i * b for a, b in zip(start, step, strict=True)) for i in range(4)]
            if any(step) and all(0 <= place < 4 for square in squares for place in square):
                found.add(frozenset(16 * board + 4 * row + column for board, row, column in squares))
    return found


LINES = lines()
DRAWN = "1110100101111110001001001010110101011101100100100101001000111000"


def wins(squares: set[int]) -> bool:
    return any(line <= squares for line in LINES)


class Board:
    """A game whose moves are made with the sticks. `rewards` are the sums, `squares` those of each player."""

    def __init__(self, difficulty: int = 0) -> None:
        self.core = started("tic_tac_toe_3d", 8, difficulty)
        self.rewards, self.squares = [0, 0], (set[int](), set[int]())

    @property
    def turn(self) -> int:
        return byte(self.core, 0xEF)

    def act(self, player: int, action: int) -> None:
        actions = [0, 0]
        actions[player] = action
        paid = self.core.act_players(actions)
        self.rewards = [total + reward for total, reward in zip(self.rewards, paid, strict=True)]

    def move(self, player: int, square: int) -> None:
        """Move the cursor, and press FIRE until the turn or the game has ended."""
        while (at := byte(self.core, 0x82)) != square:
            self.act(player, RIGHT if at % 4 != square % 4 else DOWN)
            if byte(self.core, 0x82) != at:
                self.act(player, 0)
        while self.turn == player and not self.core.game_over:
            assert byte(self.core, 0x9A + square) not in (0x08, 0x28)
            self.act(player, FIRE)
        self.squares[player].add(square)
        assert byte(self.core, 0x9A + square) == (0x08, 0x28)[player]
        if not self.core.game_over:
            self.act(player, 0)


def test_four_in_a_row_win() -> None:
    board = Board()
    for square in (0, 1, 2):
        board.move(1, square)
        board.move(0, square + 4)
    assert (board.rewards, board.core.game_over) == ([0, 0], False)
    board.move(1, 3)
    assert (board.rewards, board.core.game_over) == ([-1, 1], True)


@pytest.mark.parametrize("difficulty", [0, 2])
def test_the_right_switch_says_who_begins_and_only_that_player_can_move(difficulty: int) -> None:
    board = Board(difficulty)
    first = 1 if difficulty == 0 else 0
    assert board.turn == first
    for frame in range(200):
        board.act(1 - first, (FIRE, RIGHT, DOWN, 0)[frame // 10 % 4])
    assert (board.turn, byte(board.core, 0x82)) == (first, 0)
    board.move(first, 21)
    assert board.turn == 1 - first


@pytest.mark.parametrize("seed", range(6))
def test_the_game_ends_when_a_line_is_complete(seed: int) -> None:
    source, board, free = random.Random(seed), Board(seed % 2 * 2), list(range(64))
    source.shuffle(free)
    while not board.core.game_over:
        player = board.turn
        board.move(player, free.pop())
        assert board.core.game_over == wins(board.squares[player])
    assert board.rewards == ([1, -1] if player == 0 else [-1, 1])


def test_a_full_board_is_a_draw() -> None:
    owners = [int(owner) for owner in DRAWN]
    left = [[square for square in range(64) if owners[square] == player] for player in range(2)]
    assert len(left[0]) == len(left[1])
    board = Board()
    for moves in range(64):
        assert not board.core.game_over
        if moves > 60:
            for _ in range(60):  # the cursor blinks on the last empty squares
                board.act(board.turn, 0)
        board.move(board.turn, left[board.turn].pop())
    assert (board.rewards, board.core.game_over) == ([0, 0], True)


class Word:
    """A game of Hangman. `rewards` are the sums."""

    def __init__(self, mode: int, seed: int = 1, difficulty: int = 0) -> None:
        self.core = MultiplayerCore("hangman", mode=mode, seed=seed, difficulty=difficulty)
        self.core.reset()
        self.rewards = [0, 0]
        letters = [byte(self.core, address) for address in range(0xF3, 0xF9)]
        self.word = "".join(chr(65 + letter) for letter in letters if letter < 26)

    @property
    def turn(self) -> int:
        return byte(self.core, 0xE9) & 1

    def act(self, player: int, action: int, frames: int = 1) -> None:
        for _ in range(frames):
            actions = [0, 0]
            actions[player] = action
            paid = self.core.act_players(actions)
            self.rewards = [total + reward for total, reward in zip(self.rewards, paid, strict=True)]

    def guess(self, letter: str) -> None:
        """Choose a letter, with the stick of the player whose turn it is."""
        player = self.turn
        while byte(self.core, 0xEF) != ord(letter) - 65:
            at = byte(self.core, 0xEF)
            while byte(self.core, 0xEF) == at:
                self.act(player, UP)
            self.act(player, 0, 3)
        self.act(player, FIRE, 4)
        self.act(player, 0, 30)

    def result(self) -> tuple[list[int], bool, list[int]]:
        scores = [10 * (score >> 4) + (score & 15) for score in (byte(self.core, 0xEB), byte(self.core, 0xEC))]
        return self.rewards, self.core.game_over, scores


@pytest.mark.parametrize("mode", [4, 5, 6, 7])
@pytest.mark.parametrize("seed", [1, 3, 4])
def test_the_player_who_completes_a_word_wins(mode: int, seed: int) -> None:
    game = Word(mode, seed)
    wrong = [letter for letter in "BFJKVWXZ" if letter not in game.word]
    right = sorted(set(game.word))
    for turn, letter in ((0, right[0]), (0, wrong[0]), (1, wrong[1]), (0, wrong[2]), (1, right[1])):
        assert game.turn == turn
        game.guess(letter)
    assert game.result() == ([0, 0], False, [0, 0])
    for letter in right[2:]:
        assert game.turn == 1
        game.guess(letter)
    assert game.result() == ([-1, 1], True, [0, 1])
    game = Word(mode, seed)
    for letter in right:
        game.guess(letter)
    assert game.result() == ([1, -1], True, [1, 0])


@pytest.mark.parametrize("mode", [4, 5, 6, 7])
def test_eleven_wrong_letters_end_the_game_without_a_winner(mode: int) -> None:
    game = Word(mode)
    wrong = [letter for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ" if letter not in game.word]
    for number in range(11):
        assert (game.turn, game.core.game_over) == (number % 2, False)
        game.guess(wrong[number])
    assert game.result() == ([0, 0], True, [0, 0])


def test_players_of_hangman_wait_for_each_other_until_the_cartridge_ends_the_game() -> None:
    game = Word(5)
    for frame in range(16_364):
        assert (game.core.game_over, byte(game.core, 0xEF)) == (False, 0)
        game.act(1, (FIRE, UP, DOWN, 0)[frame // 8 % 4])  # it is the turn of player 1
    assert game.result() == ([0, 0], True, [0, 0])


@pytest.mark.parametrize("difficulty", range(4))
def test_a_difficulty_switch_gives_its_player_20_seconds(difficulty: int) -> None:
    game, turns = Word(5, difficulty=difficulty), []
    for player in range(2):
        game.act(0, 0, 1300)
        turns.append(game.turn != player)
        if not turns[-1]:
            game.guess(next(letter for letter in "XQZ" if letter not in game.word))
    assert turns == [bool(difficulty & 1), bool(difficulty & 2)]


DIGESTS = {
    "atlantis": "4d16b49477404ffd",
    "blackjack": "d282351c50ef9e16",
    "hangman": "1afaf8cc3fd209c2",
    "bowling": "198409a8e31989d5",
    "human_cannonball": "8c20a6e93a71cced",
    "tic_tac_toe_3d": "5b0ca2377b45f05b",
}
"""By game with rules that Multi-Agent-ALE does not have."""
LONGER = {"atlantis": 7000, "blackjack": 5000}
"""Games with few modes and difficulties, and the frames of each."""


@pytest.mark.parametrize("game", DIGESTS)
def test_random_games_are_as_before(game: str) -> None:
    """A digest of RAM, rewards, lives and ends, in each mode, with each difficulty and sticky actions."""
    seen = hashlib.sha256()
    rules = atari.games[game].multiplayer
    assert rules is not None
    for mode, difficulty in itertools.product(rules.modes[2], rules.difficulties):
        core = MultiplayerCore(game, mode=mode, difficulty=difficulty, seed=7, repeat_action_probability=0.25)
        core.reset()
        actions = random_actions(mode, 8, tuple(range(18)))
        for frame in range(LONGER.get(game, 3000)):
            rewards = core.act_players(actions(frame))
            seen.update(core.ram().tobytes() + repr((rewards, core.player_lives, core.game_over)).encode())
    assert seen.hexdigest()[:16] == DIGESTS[game]
