"""Published scores of a game beside those of random play and of a human."""

from collections.abc import Iterator
from functools import cache

from atari.games.game import Game
from atari.learning import Published
from gamepages.markup import folded, table, text
from gamepages.plays import Play

# Agents that a page shows at once; the others are folded.
FIRST = (
    "papers/dqn2015", "papers/rainbow", "papers/agent57", "dopamine/dqn", "dopamine/rainbow", "dopamine/iqn",
    "dreamerv3/atari57/dreamerv3", "dreamerv3/atari57/muzero", "sb3_zoo/ppo", "cleanrl/ppo_atari_envpool",
)  # fmt: skip


@cache
def _agents() -> tuple[Published, ...]:
    return tuple(Published(name) for name in Published.names())


def number(score: float) -> str:
    """A score with at most one digit after the point."""
    return f"{score:,.1f}".removesuffix(".0")


def html(game: Game, play: Play | None) -> str:
    """The scores of a page."""
    rows = []
    if game.id in Published.human_scores():
        random, human = Published.human_scores()[game.id]
        rows += [
            ("random play", number(random), "starts after no-ops, table noop57"),
            ("human", number(human), "starts after no-ops, table noop57"),
        ]
    if play is not None:
        seconds = f"{play.frames / game.screen.frame_rate:.0f} s"
        rows += [
            (f"the play above ({text(play.policy)})", number(play.score), f"{seconds} of one game, no sticky actions"),
            ("random play for as long", number(play.random_score), f"{seconds}, mean of three"),
        ]
    known = {agent.name: agent for agent in _agents() if game.id in agent.games}
    rows += _rows(game, [known[name] for name in FIRST if name in known])
    parts = [table(("", "score", "how"), rows)] if rows else ["<p>No score of this game has been published.</p>\n"]
    others = [agent for name, agent in known.items() if name not in FIRST]
    if others:
        parts.append(folded(f"{len(others)} more published agents", table(("", "score", "how"), _rows(game, others))))
    return "".join(parts)


def _rows(game: Game, agents: list[Published]) -> Iterator[tuple[str, str, str]]:
    for agent in agents:
        scores = agent.final(game.id)
        if not len(scores):
            continue
        sticky = agent.protocol.get("repeat_action_probability")
        conditions = [
            f"{agent.final_frames / 1e6:,.3g} million frames" if agent.final_frames else "",
            "" if sticky is None else f"sticky actions {sticky}" if sticky else "no sticky actions",
            f"mean of {len(scores)} seeds" if len(scores) > 1 else "",
        ]
        how = ", ".join(condition for condition in conditions if condition)
        yield f"{text(agent.title)} <small>{text(agent.name)}</small>", number(float(scores.mean())), how
