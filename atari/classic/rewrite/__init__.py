"""`python -m atari.classic --modern FILE`: scripts and notebooks for Gym, rewritten for Gymnasium.

`modernized` edits ranges of the text that the syntax tree finds. What it does not understand, it marks with a comment
that begins with `# atari.classic:`.
"""

from atari.classic.rewrite.attributes import Attributes
from atari.classic.rewrite.classes import Classes
from atari.classic.rewrite.environments import Environments
from atari.classic.rewrite.imports import Imports
from atari.classic.rewrite.making import Making
from atari.classic.rewrite.results import Results
from atari.classic.rewrite.script import Script
from atari.classic.rewrite.source import Source

__all__ = ["modernized"]


def modernized(text: str) -> Source:
    """The edits that make a script for Gym one for Gymnasium.

    In a script that imports Gymnasium, only what is wrong there is edited, such as four values of `step`.

    Raises:
        SyntaxError: the text is not of this version of Python.

    Example:
        >>> from atari.classic.rewrite import modernized
        >>> print(modernized("import gym\\nenv = gym.make('CartPole-v1')\\nstate = env.reset()").result())
        import gymnasium as gym
        env = gym.make('CartPole-v1')
        state, _ = env.reset()
    """
    script = Script(text)
    environments = Environments(script)
    needs_atari = False
    if environments.is_old:
        results = Results(script, environments)
        results.rewrite()
        Classes(script, environments, results).rewrite()
        making = Making(script, environments)
        making.rewrite()
        Attributes(script, environments).rewrite()
        needs_atari = making.needs_atari
    Imports(script, environments.is_old, environments.careful).rewrite(needs_atari)
    return script.source
