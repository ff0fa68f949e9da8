"""The index of the games: a list of pictures, which a script filters."""

from collections.abc import Collection, Iterator

from atari.games.game import Game
from gamepages import facts
from gamepages.facts import SCREEN
from gamepages.markup import text

_FILTERS = (
    ("actions", "Actions", (("2-4", "up to 4"), ("5-9", "5 to 9"), ("10-17", "10 to 17"), ("18-18", "all 18"))),
    ("lives", "Lives", (("0-0", "none"), ("1-3", "1 to 3"), ("4-99", "4 or more"))),
    ("players", "Players", (("1-1", "one only"), ("2-9", "two or more"), ("4-9", "four"))),
    ("labels", "RAM names", (("1-9", "1 to 9"), ("10-19", "10 to 19"), ("20-128", "20 or more"))),
    ("sticky", "IDs", (("1-1", "with sticky actions only (v5)"), ("2-2", "with and without (v4)"))),
)


def page(games: Collection[Game], shown: Collection[str]) -> str:
    """The index; `shown` are the games with media in this build."""
    return "\n".join(_lines(games, shown))


def _lines(games: Collection[Game], shown: Collection[str]) -> Iterator[str]:
    alone = sum(game.single_player for game in games)
    yield "---\ntitle: Games\nhide: [navigation, toc]\n---\n"
    yield "# Games\n"
    yield (
        f'<p class="lead">{len(games)} cartridges, {alone} of them with games of one player. Each page has a play '
        "with sound, actions, modes, rules, scores and the names of RAM.</p>\n"
    )
    if len(shown) < len(games):
        yield f"This build has pictures and videos of {len(shown)} of them.\n"
    yield _form()
    yield '<ul class="games">'
    yield from (_card(game, game.id in shown) for game in sorted(games, key=lambda game: game.title.lower()))
    yield '</ul>\n<script src="../assets/games.js" defer></script>'


def _form() -> str:
    fields = [
        '<form class="game-filters" hidden><label>Name <input type="search" name="name" autocomplete="off"></label>'
    ]
    for name, label, choices in _FILTERS:
        options = "".join(f'<option value="{value}">{text(words)}</option>' for value, words in choices)
        fields.append(f'<label>{label} <select name="{name}"><option value="">any</option>{options}</select></label>')
    return "\n".join([*fields, '<output aria-live="polite"></output></form>'])


def _card(game: Game, shown: bool) -> str:
    manual, count = game.manual, facts.lives(game)
    sticky = {0: 0, 2: 1}.get(len(facts.families(game)), 2)  # IDs of v5 alone have sticky actions
    actions = game.minimal_actions or (game.multiplayer.minimal_actions if game.multiplayer else ())
    values = {
        "name": f"{game.title} {game.id} {manual.maker if manual else ''}".lower(),
        "actions": len(actions),
        "lives": 0 if count is None else count,
        "players": facts.most_players(game),
        "labels": len(game.ram_labels),
        "sticky": sticky,
    }
    data = " ".join(f'data-{name}="{text(str(value))}"' for name, value in values.items())
    picture = (
        f'<img src="{game.id}/{SCREEN}" width="320" height="{game.screen.height}" loading="lazy" alt="">'
        if shown
        else '<span class="none"></span>'
    )
    released = f"{manual.year} " if manual and manual.year else ""
    small = f"{released}· {len(actions)} actions" if released else f"{len(actions)} actions"
    link = f'<a href="{game.id}.html">{picture}<strong>{text(game.title)}</strong></a>'
    return f"<li {data}>{link}<small>{small}</small></li>"
