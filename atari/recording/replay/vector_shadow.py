"""`LaneShadow`: one environment of a vector, played again on a core whose calls are recorded.

A vector plays its environments in C++ and does not return the frames inside a step or the no-ops of a reset. A shadow
has the same seed and plays the same actions, so its RAM and frame numbers must be equal after each step.
"""

from typing import Any

from atari.base.gymnasium_versions import AutoresetMode
from atari.env import AtariEnv
from atari.observations.settings import make_episode
from atari.vector.env import AtariVectorEnv
from atari.vector.options import VectorOptions


class LaneShadow:
    """Repeats the resets and steps of environment `index` of a vector.

    Args:
        vector, index: the vector, and the number of the environment.
        env: the recorder around the `shadow_env` of the environment.
    """

    def __init__(self, vector: AtariVectorEnv, index: int, env: Any) -> None:
        self.env = env
        self.core: Any = env.unwrapped.core
        """The recorded core."""
        self._actions = vector.options.actions[index]
        self._autoreset = vector.autoreset_mode
        self._episode = make_episode(vector.options.tasks[index], observed=False)

    def reset(self, seed: list[int] | None = None, new_game: bool = False) -> None:
        """Begin an episode, as the environment has.

        Args:
            seed: nine words, of `atari.vector.seeds`; None continues the generators.
            new_game: whether a lost life does not continue the game.
        """

        def begin() -> Any:
            if seed is not None:
                self.core.seed(seed[0])
            self.core.reset()
            return self.core

        self._episode.reset(self.core, begin, seed=seed, new_game=new_game)
        self.env.recorder.flush_if_full()

    def step(self, index: int, strength: float) -> None:
        """Repeat a step, with an action's index and strength."""
        was_over = self._episode.ended
        if not was_over:
            self.env.recorder.begin_step()
            self._episode.step(self.core, int(self._actions[index]), strength)
            self.env.recorder.end_step()
        begins = {AutoresetMode.NEXT_STEP: was_over, AutoresetMode.SAME_STEP: self._episode.ended}
        if begins.get(self._autoreset):
            self.reset()


def shadow_env(options: VectorOptions, index: int) -> AtariEnv:
    """An `AtariEnv` with the core of environment `index` of a vector; the replay's header describes it.

    With ale-py's seeding, the header has the emulator's fields and the frame skip; otherwise it has the whole task.
    """
    task = options.tasks[index]
    alone = task.emulator_task() if task.preprocessed else task.replace(max_episode_steps=None)
    if options.mixed:
        alone = alone.replace(actions="full")
    if task.seeding == "ale":
        return AtariEnv(alone.replace(frameskip=task.frameskip), rom=options.rom)
    env = AtariEnv(alone, rom=options.rom)
    env.whole_task = task
    return env
