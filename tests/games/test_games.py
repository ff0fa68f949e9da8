"""`atari.games`: the game files, read and checked. `conformance/` compares their content with ale-py."""

import copy
import dataclasses
import pickle
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

import pytest
from rules_interpreter import evaluate

import atari
from atari import Action
from atari.games.actions import Switch
from atari.games.game import Controllers, RamLabel, Rom, Screen, load_game
from atari.games.rules import _OPERATIONS, HELPERS, Rules
from atari.roms import find

SCHEMA = (Path(atari.__file__).parent / "games" / "SCHEMA.md").read_text(encoding="utf-8")
GAME = """
title = "Example"
players = 1
notes = ["A game."]

[rom]
md5 = "0123456789abcdef0123456789abcdef"
sha256 = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"
size = 4096
cartridge = "4K"

[screen]
format = "NTSC"
height = 210
first_line = 34

[controllers]
left = "paddles"
right = "joystick"
paddle_range = [27450, 790196]

[actions]
minimal = ["NOOP", "FIRE"]
legal = "all"
starting = ["RESET", "FIRE"]

[settings]
modes = [0, 4]
default_mode = 4
difficulties = [0, 1]

[rules]
lives_initial = 3
state = {score = 0}
step = '''
points   = bcd(0x84, 0x83)
reward   = points - score
score    = points
terminal = ram[0x90] == 0
lives    = 0 if terminal else ram[0x91] & 7
'''
mode_select = [{op = "press_select_until", frames = 2, until = "ram[0xBD] == mode"}, {op = "soft_reset"}]

[ram]
ball_x = {index = 5, kind = "position_x", transform = "v - 7", visible = "ram[6] != 0", sources = ["measured"], evidence = "confirmed"}
"""


def test_there_are_108_games_and_104_can_be_played() -> None:
    assert len(atari.games) == len(list(atari.games.values())) == 108
    assert list(atari.games) == sorted(atari.games)
    assert atari.games["pong"] is atari.games["pong"]  # it is read once
    assert list(atari.games.playable()) == [game for game in atari.games.values() if game.single_player]
    others = {game.id: game.players for game in atari.games.values() if not game.single_player}
    assert others == {"combat": 2, "joust": 2, "maze_craze": 2, "warlords": 4}
    for game in map(atari.games.__getitem__, others):
        assert (game.rules, game.minimal_actions, game.modes, game.difficulties) == (None, (), (), ())
    for fact in ("id", "title", "rom"):
        assert len({getattr(game, fact) for game in atari.games.values()}) == 108
    assert sum(len(game.ram_labels) for game in atari.games.values()) == 1902


def test_a_game_states_its_facts() -> None:
    game = atari.games["ms_pacman"]
    assert (game.id, game.title, game.players) == ("ms_pacman", "Ms. Pac-Man", 1)
    assert [action.name for action in game.minimal_actions[:3]] == ["NOOP", "UP", "RIGHT"]
    assert len(game.legal_actions) == 18
    assert (game.modes, game.default_mode, game.difficulties) == ((0, 1, 2, 3), 0, (0,))
    assert game.screen.shape == (210, 160)
    assert game.screen.frame_rate == 60.0
    assert game.rules is not None
    assert game.rules.lives_initial == 3
    pal = [game.id for game in atari.games.playable() if game.screen.frame_rate == 50.0]
    assert {"adventure", "air_raid", "pacman", "sir_lancelot"} <= set(pal)
    assert all(atari.games[game].screen.height == 250 for game in pal)
    rules = atari.games["pong"].rules
    assert rules is not None
    assert (rules.expression("reward"), rules.expression("points")) == ("points - score", "ram[0x8E] - ram[0x8D]")
    label = atari.games["breakout"].ram_labels["ball_x"]
    assert (label.name, label.index, label.kind) == ("ball_x", 99, "position_x")
    assert (label.transform, label.visible) == ("v - 49", "ram[101] != 0 and ram[101] <= 185")
    assert "measured" in atari.games["berzerk"].ram_labels["lives"].sources


def test_nothing_can_be_changed() -> None:
    assert isinstance(atari.games, Mapping)
    game = atari.games["breakout"]
    assert game.rules is not None
    mappings: list[tuple[Any, str]] = [(atari.games, "pong"), (game.ram_labels, "ball_x"), (game.rules.state, "score")]
    for mapping, key in mappings:
        with pytest.raises(TypeError, match="item assignment"):
            mapping[key] = mapping[key]
        with pytest.raises(TypeError, match="item deletion"):
            del mapping[key]
    with pytest.raises(dataclasses.FrozenInstanceError):
        game.title = "Breakin"  # type: ignore[misc]


@pytest.mark.parametrize("game", ["breakout", "warlords"])
def test_a_game_can_be_hashed_copied_and_pickled(game: str) -> None:
    original = atari.games[game]
    for other in (pickle.loads(pickle.dumps(original)), copy.deepcopy(original)):
        assert other == original
        assert hash(other) == hash(original)


def test_repr_says_what_matters() -> None:
    assert repr(atari.games["breakout"]) == (
        "Game('breakout', 'Breakout', 4 actions, 12 modes, 2 difficulties, NTSC 160x210)"
    )
    assert repr(atari.games["warlords"]) == "Game('warlords', 'Warlords', 4 players, no single-player rules)"
    assert repr(atari.games) == "<108 games: adventure ... zaxxon>"


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("brekout", "breakout"),
        ("Breakout", "breakout"),
        ("MsPacman", "ms_pacman"),
        ("space-invaders", "space_invaders"),
        ("montezumas_revenge", "montezuma_revenge"),
        ("tictactoe", "tic_tac_toe_3d"),
        ("qqqq", None),
    ],
)
def test_an_unknown_game_suggests_the_nearest(wrong: str, right: str | None) -> None:
    hint = f"did you mean '{right}'\\?" if right else "see `atari info` for all of them"
    assert wrong not in atari.games
    for look_up, error in ((atari.games.__getitem__, KeyError), (atari.games.find, ValueError)):
        with pytest.raises(error, match=f"there is no game '{wrong}'; {hint}"):
            look_up(wrong)


@pytest.mark.parametrize("game", atari.games)
def test_label_expressions_have_a_value_for_any_ram(game: str) -> None:
    assert atari.games[game].ram_labels
    for label in atari.games[game].ram_labels.values():
        for ram in (bytes(128), bytes(range(128)), b"\xff" * 128):
            if label.visible is not None:
                assert evaluate(label.visible, ram, {"v": ram[label.index]}, base=0) in (0, 1), label
            if label.transform is not None:
                assert abs(evaluate(label.transform, ram, {"v": ram[label.index]}, base=0)) < 2**31, label


# Files.


def load(folder: Path, text: str) -> atari.Game:
    file = folder / "example.toml"
    file.write_text(text)
    return load_game(file)


def test_a_file_becomes_a_game(tmp_path: Path) -> None:
    game = load(tmp_path, GAME)
    assert game.id == "example"
    assert game.minimal_actions == (Action.NOOP, Action.FIRE)
    assert game.starting_actions == (Switch.RESET, Action.FIRE)
    assert game.controllers.paddles
    assert game.controllers.paddle_range == (27450, 790196)
    assert game.screen.format_detected
    assert game.ram_labels["ball_x"].sources == ("measured",)
    assert game.rules is not None
    assert [name for name, _ in game.rules.step] == ["points", "reward", "score", "terminal", "lives"]
    assert game.rules.mode_select[0].frames == "2"


def test_the_rules_may_be_absent(tmp_path: Path) -> None:
    head, tail = GAME.index("[actions]"), GAME.index("[ram]")
    game = load(tmp_path, GAME[:head] + GAME[tail:])
    assert not game.single_player
    assert list(game.ram_labels) == ["ball_x"]


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        # The file and its tables.
        ('title = "Example"', "", "the file needs the key 'title'"),
        ('title = "Example"', "title = 3", "the file: 'title' must be a text, got 3"),
        ("players = 1", 'players = "one"', "the file: 'players' must be a whole number, got 'one'"),
        ('notes = ["A game."]', 'notes = "A game."', "the file: 'notes' must be a list of texts, got 'A game.'"),
        ("players = 1", "players = 1\nauthor = 'me'", "the file has no key 'author'; it can have title, players, not"),
        ("[ram]", "[rams]", "the file has no key 'rams'; did you mean 'ram'? it can have"),
        ("[rules]", "[rulez]", "the file has no key 'rulez'"),
        ('minimal = ["NOOP", "FIRE"]', 'minimal = ["NOOP"', "Unclosed array"),
        # [rom]
        ('cartridge = "4K"', 'cartridge = "4K"\nmapper = "4K"', "[rom] has no key 'mapper'"),
        ("size = 4096", 'size = "4K"', "[rom]: 'size' must be a whole number, got '4K'"),
        ('md5 = "0123', 'md5 = "X123', "[rom] md5 must be 32 hexadecimal digits in lower case, got 'X123"),
        ('sha256 = "01', 'sha256 = "', "[rom] sha256 must be 64 hexadecimal digits in lower case"),
        # [screen]
        ('format = "NTSC"', 'format = "VGA"', "[screen]: 'format' must be one of NTSC, PAL, SECAM, got 'VGA'"),
        ("height = 210", "height = 199", "[screen] height 199 is not within 200..256"),
        ("height = 210", "height = true", "[screen]: 'height' must be a whole number, got True"),
        ("first_line = 34", "", "[screen] needs the key 'first_line'"),
        # [controllers]
        ('"paddles"', '"mouse"', "[controllers]: 'left' must be one of joystick, paddles, none, got 'mouse'"),
        ("[27450, 790196]", "[2]", "[controllers]: 'paddle_range' must be a list of 2 whole numbers or none, got [2]"),
        # [actions]
        ('"NOOP", "FIRE"]', '"NOOP", "JUMP"]', "[actions] unknown action 'JUMP'"),
        ('legal = "all"', 'legal = ["NOOP"]', "[actions] a minimal action is not legal"),
        ('starting = ["RESET", "FIRE"]', "", "[actions] needs the key 'starting'"),
        # [settings]
        ("default_mode = 4", "default_mode = 5", "[settings] default_mode 5 is not one of the modes"),
        ("modes = [0, 4]", 'modes = ["easy"]', "[settings]: 'modes' must be a list of whole numbers, got ['easy']"),
        ("difficulties = [0, 1]", "difficulties = [0, 4]", "[settings] difficulties [0, 4] are not among 0, 1, 2, 3"),
        ("difficulties = [0, 1]", "difficulties = []", "[settings] difficulties [] are not among 0, 1, 2, 3"),
        # [ram]
        ("index = 5", "index = 128", "[ram] ball_x: index 128 is not within 0..127"),
        ('kind = "position_x", ', "", "[ram] ball_x needs the key 'kind'"),
        ('kind = "position_x"', 'kind = "position_x", unit = 1', "[ram] ball_x has no key 'unit'"),
        ('"v - 7"', '"w - 7"', "[ram] ball_x: in 'w - 7', the name 'w' is not defined"),
        ("ram[6] != 0", "ram[0x80] != 0", "an address is a number within 0x0..0x7f, not 128"),
    ],
)
def test_a_broken_file_is_refused_with_its_name_and_the_fault(tmp_path: Path, old: str, new: str, text: str) -> None:
    assert GAME.count(old) == 1
    with pytest.raises(ValueError, match=r"example\.toml: ") as error:
        load(tmp_path, GAME.replace(old, new))
    assert text in str(error.value)


@pytest.mark.parametrize("table", ["actions", "settings", "rules"])
def test_what_makes_a_game_playable_comes_together_or_not_at_all(table: str, tmp_path: Path) -> None:
    broken, inside = [], False
    for line in GAME.splitlines():
        inside = line == f"[{table}]" if line.startswith("[") else inside
        broken += [] if inside else [line]
    with pytest.raises(ValueError, match=f"the file needs the key '{table}'"):
        load(tmp_path, "\n".join(broken))


def test_a_file_that_is_not_there_raises(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        load_game(tmp_path / "nothing.toml")


def test_the_example_of_the_schema_is_a_game(tmp_path: Path) -> None:
    """The document shows a whole file: the first TOML block that begins with a title."""
    blocks = [block.partition("```")[0] for block in SCHEMA.split("```toml\n")[1:]]
    example = next(block for block in blocks if block.startswith("title"))
    game = load(tmp_path, example)
    assert game.single_player


def test_the_schema_names_every_key() -> None:
    kinds: list[Any] = [Rom, Screen, Controllers, RamLabel]
    names = {field.name for kind in kinds for field in dataclasses.fields(kind)} - {"name", "width"}
    names |= {field.name for field in dataclasses.fields(Rules)}
    names |= {"minimal", "legal", "starting", "modes", "default_mode", "difficulties", "title", "players", "notes"}
    names |= set(HELPERS) | set(_OPERATIONS)
    assert [name for name in sorted(names) if f"`{name}" not in SCHEMA] == []


def test_the_documents_list_every_cartridge_type(tmp_path: Path) -> None:
    """The emulator's error names the types of its table."""
    pong = (Path(atari.__file__).parent / "games" / "data" / "pong.toml").read_text(encoding="utf-8")
    game = load(tmp_path, re.sub('cartridge = "[^"]*"', 'cartridge = "?"', pong))
    with pytest.raises(ValueError, match="there is no cartridge type") as caught:
        atari.cores.NativeCore(game, rom=find(atari.games["pong"]))
    types = str(caught.value).partition("the types are ")[2].split(", ")
    row = next(line for line in SCHEMA.splitlines() if line.startswith("| `cartridge` |"))
    assert re.findall("`([^`]*)`", row) == ["cartridge", *types]
    guide = (Path(__file__).parents[2] / "docs" / "own-games.md").read_text(encoding="utf-8")
    listed = guide.partition("## Supported cartridge types\n\n")[2].partition(";")[0].replace(" and ", ", ").split(", ")
    assert listed == [one for one in types if one != "F8 SWAPPED"]  # which images begin in the other bank is a table


def test_the_schema_names_every_choice() -> None:
    for kind in (Screen, Controllers, RamLabel):
        for name, annotation in get_type_hints(kind).items():
            if get_origin(annotation) is Literal:
                row = next(line for line in SCHEMA.splitlines() if re.match(rf"\| (`\w+`, )*`{name}`[ ,]", line))
                assert [value for value in get_args(annotation) if f'"{value}"' not in row] == [], name


def test_an_unknown_label_suggests_the_nearest() -> None:
    labels = atari.games["breakout"].ram_labels
    with pytest.raises(KeyError, match=r"there is no 'live'; did you mean 'lives'\?"):
        labels["live"]
    assert labels.get("live") is None
    assert "live" not in labels
