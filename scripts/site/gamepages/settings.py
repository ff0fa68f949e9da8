"""Actions, modes, difficulties, RAM labels and interventions of a game, as tables."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from atari.games.actions import PLAYER_ACTIONS
from atari.games.game import Game, RamLabel
from atari.games.interventions import Intervention
from atari.games.labels import value_source
from gamepages.facts import keys
from gamepages.families import families, merged, series, shortened
from gamepages.markup import code, folded, pictures, table, text

_UNNAMED = "<em>not known</em>"
_ONLY = "the only one"


def actions(game: Game) -> str:
    """The minimal actions, then all, with the keys of `atari play`."""
    minimal = game.minimal_actions or (game.multiplayer.minimal_actions if game.multiplayer else ())
    rows = ((str(index), code(action.name), str(int(action)), keys(action)) for index, action in enumerate(minimal))
    every = ((str(int(action)), code(action.name), keys(action)) for action in PLAYER_ACTIONS)
    return table(("action", "name", "of all 18", "keys"), rows) + folded(
        "All 18 actions, with full_action_space=True", table(("action", "name", "keys"), every)
    )


def modes(game: Game, numbers: Sequence[int], picture: str | None) -> str:
    """Each mode with its meaning, and a picture of it if there is a sheet."""
    manual = game.manual
    meanings = {**manual.multiplayer_modes, **manual.modes} if manual and game.single_player else {}
    if manual and not game.single_player:
        meanings = dict(manual.multiplayer_modes)
    default = game.default_mode if game.single_player else None
    marks = [f"{number} (default)" if number == default else str(number) for number in numbers]
    words = [text(meanings.get(number, _ONLY if len(numbers) == 1 else "")) for number in numbers]
    if picture is None:
        return table(("mode", "meaning"), zip(marks, (word or _UNNAMED for word in words), strict=True))
    captions = [f"<strong>{mark}</strong> {word}" for mark, word in zip(marks, words, strict=True)]
    kind = "large" if len(numbers) <= 4 else "small"
    return pictures(picture, captions, ratio=f"320 / {game.screen.height}", kind=kind)


def difficulties(game: Game) -> str:
    """Each difficulty with its meaning."""
    numbers = game.difficulties or (game.multiplayer.difficulties if game.multiplayer else ())
    known, missing = game.manual.difficulties if game.manual else {}, _ONLY if len(numbers) == 1 else ""
    return table(
        ("difficulty", "meaning"), ((str(number), text(known.get(number, missing)) or _UNNAMED) for number in numbers)
    )


def shared_modes(game: Game) -> str:
    """The modes of several players."""
    assert game.multiplayer is not None
    known = game.manual.multiplayer_modes if game.manual else {}
    rows = (
        (str(mode), str(players), text(known.get(mode, "")) or _UNNAMED)
        for players, modes in game.multiplayer.modes.items()
        for mode in modes
    )
    return table(("mode", "players", "meaning"), rows)


def ram(game: Game) -> str:
    """A row for each named byte, and one for each family of names."""
    found = families(game.ram_labels.values(), _meaning)
    return table(("byte", "address", "name", "kind", "meaning"), map(_ram_row, found))


def _ram_row(labels: Sequence[RamLabel]) -> Sequence[str]:
    """The row of a label, or of the labels of a family."""
    ends = labels if labels[0] is labels[-1] else (labels[0], labels[-1])
    evidence = Counter(label.evidence for label in labels if label.evidence)
    counts = [text(name if count == len(labels) else f"{name} ({count})") for name, count in evidence.items()]
    return (
        series([str(label.index) for label in labels]),
        " to ".join(code(f"0x{0x80 + label.index:02X}") for label in ends),
        shortened([code(label.name) for label in labels]),
        labels[0].kind.replace("_", " "),
        ". ".join(filter(None, (merged([_meaning(label) for label in labels]), ", ".join(counts)))),
    )


def interventions(known: Iterable[Intervention]) -> str:
    """A row for each intervention."""
    return table(("name", "what it changes"), ((code(one.name), text(one.description)) for one in known))


def _meaning(label: RamLabel) -> str:
    """What a label says of its byte, without the evidence."""
    return ". ".join(_facts(label))


def _facts(label: RamLabel) -> Iterator[str]:
    if label.note:
        yield text(label.note)
    source = value_source(label)
    if source != "v":
        yield f"value {code(source)}"
    if label.x is not None or label.y is not None:
        yield f"always in column {label.x}" if label.y is None else f"always in row {label.y}"
    if label.visible is not None:
        yield f"visible when {code(label.visible)}"
