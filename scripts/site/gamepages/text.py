"""The page of a game, as Markdown."""

import re
from collections.abc import Iterator

import player

from atari.games.game import Game
from atari.games.interventions import load
from atari.multiplayer import ENVIRONMENTS
from atari.task import PRESETS
from atari.task.env_ids import stem
from gamepages import facts, scores, settings
from gamepages.facts import FILM, MODES, SCREEN, VIDEO, VIEWS, shown_modes
from gamepages.markup import code, folded, pictures, table, text
from gamepages.plays import Play, play_of

_POLICIES = {
    "search": "a search with snapshots",
    "agent": "a trained agent",
    "script": "a script that reads RAM by name",
    "random": "random actions, as nothing better is there",
}


def page(game: Game, media: frozenset[str]) -> str:
    """The page of a game; `media` are the names of its files in the folder of the page's name."""
    return "\n".join(_sections(game, media, play_of(game.id)))


def _sections(game: Game, media: frozenset[str], play: Play | None) -> Iterator[str]:
    yield f"---\ntitle: {game.title}\nhide: [navigation]\n---\n"
    yield f"# {text(game.title)}\n"
    yield _head(game, media, play)
    if player.is_built():
        yield _play_here(game, "show" if FILM in media else "game")
    yield f"## Make it\n\n{_lines(game)}\n"
    yield f"## Rules\n\n{_rules(game)}\n"
    yield f"## Actions\n\n{settings.actions(game)}\n{_start(game)}\n"
    sheet = f"{game.id}/{MODES}" if MODES in media else None
    yield f"## Modes\n\n{settings.modes(game, shown_modes(game), sheet)}\n"
    if game.single_player and game.multiplayer:
        count = sum(map(len, game.multiplayer.modes.values()))
        yield folded(f"{count} modes of several players", settings.shared_modes(game))
        yield "These modes are those of the [environments of several players](../multiplayer.md).\n"
    yield f"## Difficulties\n\n{settings.difficulties(game)}\n"
    if game.single_player:
        yield f"## Scores\n\n{scores.html(game, play)}\n"
        yield "[Evaluation](../evaluation.md) compares yours with them, under their protocols.\n"
    if VIEWS in media:
        yield f"## What an agent sees\n\n{_views(game)}\n"
        yield "[The presets](../presets.md) compares them row by row.\n"
    if game.ram_labels:
        yield f"## RAM\n\n{len(game.ram_labels)} names; [RAM by name](../ram.md) reads and writes them.\n"
        yield settings.ram(game)
    if changes := load(game):
        one = next(iter(changes))
        made = f'`atari.make("{game.id}", interventions=["{one}"])` or `atari play {game.id} --intervention {one}`'
        yield f"## Interventions\n\n[Interventions](../interventions.md) change the game: {made}.\n"
        yield settings.interventions(changes.values())
    yield from _notes(game)


def _head(game: Game, media: frozenset[str], play: Play | None) -> str:
    manual = game.manual
    released = [str(fact) for fact in (manual.year, manual.maker) if fact is not None] if manual else []
    most = facts.most_players(game)
    players = str(game.players) if game.players >= most else f"{game.players} to {most}"
    sold = [f"cartridge: {manual.title}"] if manual and manual.title.lower() != game.title.lower() else []
    line = " · ".join([*released, f"{players} player{'s' if players != '1' else ''}", *sold, game.screen.format])
    about = f"<p>{text(manual.description)}</p>" if manual else ""
    return (
        f'<p class="lead">{text(line)}</p>\n<div class="game-head">\n'
        f"{_show(game, media, play)}\n<div>{about}</div>\n</div>\n"
    )


def _show(game: Game, media: frozenset[str], play: Play | None) -> str:
    """The video with its caption, or words in its place."""
    if VIDEO not in media:
        return '<p class="no-media">This build of the site has no pictures and no video of this game.</p>'
    where, size = f"{game.id}/", f'width="640" height="{2 * game.screen.height}"'
    if play is None:
        caption = "Random actions: there is no recorded play of this game."
    else:
        setting = "" if play.mode == game.default_mode else f" in mode {play.mode}"
        caption = (
            f"Played by {_POLICIES.get(play.policy, play.policy)}{setting}: {scores.number(play.score)} points in "
            f"{play.frames / game.screen.frame_rate:.0f} s; random play: {scores.number(play.random_score)}. {play.how}"
        )
    return (
        f'<figure class="play"><video autoplay muted loop playsinline controls {size} poster="{where}{SCREEN}" '
        f'src="{where}{VIDEO}"></video>'
        f'<img src="{where}{SCREEN}" {size} alt="The screen of {text(game.title)}">'
        f'<button type="button" class="sound" hidden>Sound on</button>'
        f'<figcaption>{text(caption)}</figcaption></figure><script src="../assets/games.js" defer></script>'
    )


def _play_here(game: Game, shown: str) -> str:
    """The page in which the game plays, which a click opens. It shows the recorded play, or the game."""
    address = f"../{player.PLAYER}#{shown}={game.id}"
    return (
        f'<details class="play-here"><summary>Play here</summary><iframe src="{address}" title="{text(game.title)}" '
        f'allow="autoplay; gamepad; fullscreen" loading="lazy"></iframe><p><a href="{address}">The same on a page of '
        "its own</a>. It takes your ROM files, or a wheel of ale-py, and sends nothing anywhere.</p></details>\n"
    )


def _lines(game: Game) -> str:
    """Lines to copy: the package's names, an ID of each family, EnvPool's name, the command line."""
    lines = ["import atari", "import gymnasium", ""]
    if game.single_player:
        lines += [f'env = atari.make("{game.id}", preset="dqn2015")', f'envs = atari.AtariVectorEnv("{game.id}", 8)']
    made = [f'env = gymnasium.make("{family.id(game.id)}")' for family in facts.families(game)]
    lines += ["", *made] if made else []
    if game.single_player:
        lines += ["", "import atari.integrations.envpool as envpool"]
        lines += [f'envs = envpool.make_gymnasium("{stem(game.id)}-v5", num_envs=8)']
    if game.multiplayer:
        names = [made.id for made in ENVIRONMENTS.values() if made.game == game.id] or [game.id]
        lines += ["", "from atari.multiplayer import parallel_env"]
        lines += [f'env = parallel_env("{name}")' for name in names]
    command = f"atari play {game.id}" + ("" if game.single_player else " --players 2")
    ids = (
        "\n[Environment IDs](../ids.md) says how these differ.\n"
        if made
        else "\nThe cartridge has no game of one player, so it has no ID in Gymnasium.\n"
    )
    return "```python\n" + "\n".join(lines) + f"\n```\n\n```bash\n{command}\n```\n{ids}"


def _rules(game: Game) -> str:
    manual, count = game.manual, facts.lives(game)
    lives = (manual.lives if manual else None) or ("" if count else "None.")
    at_reset, _ = facts.lives_at_start(game) or (count, count)
    at_start = f" At the start `info` has {count}." if count else ""
    if at_reset != count:
        at_start = f" At the reset `info` has {at_reset}, and half a second later {count}."
    if not game.single_player:
        return f"ALE has no rules of one player for this cartridge.\n\n{_expressions(game)}"
    rows = (
        ("Reward", manual.reward if manual else None, ""),
        ("Lives", lives, at_start),
        ("End of an episode", manual.end if manual else None, ""),
    )
    lines = [f"- **{name}**: {(_markdown(words or '') + more).strip()}" for name, words, more in rows if words or more]
    return "\n".join(lines) + f"\n\n{_expressions(game)}"


def _expressions(game: Game) -> str:
    """The expressions that the emulator computes after each frame."""
    rules = game.rules or (game.multiplayer.rules if game.multiplayer else None)
    rows = ((code(name), code(expression)) for name, expression in rules.step) if rules else ()
    return folded("The rules, evaluated on RAM after each frame", table(("", "value"), rows))


def _start(game: Game) -> str:
    if not game.single_player:
        return ""
    names = " ".join(f"`{action.name}`" for action in game.starting_actions)
    return f"A reset ends with {names}." if names else "A reset ends with no action of its own."


def _views(game: Game) -> str:
    captions = [f"<code>{name}</code>" for name in PRESETS]
    return pictures(f"{game.id}/{VIEWS}", captions, columns=1, ratio="345 / 84", kind="views-of-presets")


def _notes(game: Game) -> Iterator[str]:
    notes = [*(game.manual.notes if game.manual else ()), *game.notes]
    notes += game.multiplayer.notes if game.multiplayer else ()
    if notes:
        yield "## Notes\n\n" + "\n".join(f"- {_markdown(note)}" for note in notes) + "\n"
    if game.manual:
        sources = sorted({source for names in game.manual.sources.values() for source in names})
        yield f'<p class="source">Title, rules and meanings: {text(", ".join(sources))}.</p>\n'


def _markdown(words: str) -> str:
    """Text with the signs of Markdown and HTML escaped."""
    return re.sub(r"([\\`*_\[\]<|])", r"\\\1", words)
