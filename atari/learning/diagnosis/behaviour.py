"""`behaviour`: all findings about an agent, the causes before what may follow from them."""

from atari.learning.diagnosis.findings import Finding
from atari.learning.diagnosis.habits import loop, random_from
from atari.learning.diagnosis.plays import Plays
from atari.learning.diagnosis.reach import sides_not_visited, unused_presses
from atari.learning.diagnosis.senses import delayed_actions, unseen_objects

_PRESSES = {"left": "LEFT", "right": "RIGHT", "top": "UP", "bottom": "DOWN"}


def behaviour(plays: Plays) -> tuple[Finding, ...]:
    """The findings that the plays of an agent and its answers to changed observations show.

    A side to which the agent cannot go because it does not press the direction is not a finding of its own. Policies
    that play well have no findings.

    Args:
        plays: the games, see `play_games`; 20 or more. The result depends on nothing else.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.behaviour import behaviour
        >>> from atari.learning.diagnosis.plays import play_games
        >>> [finding.kind for finding in behaviour(play_games(load_policy("random"), Task.of("pong"), 2, seed=0))]
        ['random from']
    """
    presses = unused_presses(plays)
    unused = {finding.place for finding in presses}
    sides = [finding for finding in sides_not_visited(plays) if _PRESSES[finding.place] not in unused]
    found = [delayed_actions(plays), random_from(plays), *unseen_objects(plays), *presses, loop(plays), *sides]
    return tuple(finding for finding in found if finding is not None)
