"""`NoopReset`: start each episode with a random number of no-ops.

The console starts every game in the same state; a few idle frames make the starts differ (Mnih et al. 2015,
"Human-level control through deep reinforcement learning", methods: up to 30).
"""

from typing import Any

from atari.base.validation import check_integer
from atari.env.env import options_of_reset
from atari.env.episode_env import EpisodeEnv
from atari.env.restorable import RestorableWrapper, layers
from atari.wrappers._checks import Environment, begin_meanings, draw, step_named
from atari.wrappers.fire_reset import FireReset


class NoopReset(RestorableWrapper):
    """After a reset, play between `noop_min` and `noop_max` steps of NOOP.

    The number is drawn from `env.unwrapped.np_random` as in Gymnasium's and Stable-Baselines3's wrappers, so equal
    seeds give equal starts; `reset(options={"noops": n})` sets it instead. If the episode ends during the no-ops, the
    environment is reset and the rest is played. With `noop_max=0` nothing is played.

    Args:
        env: the environment; without frame skip, a step is one frame.
        noop_max: the greatest number of no-ops, 0 or more.
        noop_min: the least number of no-ops, 0..noop_max.
        fire_counts: play one no-op less in games with a FIRE action, because the FIRE of `FireReset` counts as one of
            them (EnvPool, ale-py's vector environment).
        fire_again: whether an inner `FireReset` presses FIRE again if the episode ends during the no-ops and the
            environment is reset; in ale-py's vector environment it does not.

    Raises:
        TypeError, ValueError: `noop_max` or `noop_min` is not an integer, or out of range; `fire_again` is false
            and there is no inner `FireReset`.

    Example:
        >>> import atari
        >>> from atari.wrappers import NoopReset
        >>> env = NoopReset(atari.AtariEnv("pong", frameskip=1), noop_max=30)
        >>> 1 <= env.reset(seed=0)[1]["episode_frame_number"] <= 30
        True
    """

    def __init__(
        self,
        env: Environment,
        noop_max: int = 30,
        noop_min: int = 1,
        *,
        fire_counts: bool = False,
        fire_again: bool = True,
    ) -> None:
        noop_max = check_integer("noop_max", noop_max, 0, 1_000_000)
        noop_min = min(noop_min, noop_max) if noop_max == 0 else check_integer("noop_min", noop_min, 0, noop_max)
        if not fire_again and not any(
            isinstance(layer, FireReset) or (isinstance(layer, EpisodeEnv) and layer.preprocessing.fire != "never")
            for layer in layers(env)
        ):
            raise ValueError("fire_again=False is about an inner FireReset, and there is none; leave it out")
        super().__init__(env, noop_max=noop_max, noop_min=noop_min, fire_counts=fire_counts, fire_again=fire_again)
        self.noop_max, self.noop_min = noop_max, noop_min
        self._fire_again = fire_again
        self._fires = int(fire_counts and "FIRE" in begin_meanings(env))

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset, then play no-ops.

        Args:
            seed: the seed of the environment, also for the number of no-ops.
            options: "noops" is the number of no-ops, 0 or more; the other options are passed on.

        Raises:
            TypeError, ValueError: "noops" is not such a number; nothing is reset.
        """
        inner = options_of_reset(options)
        forced = inner.pop("noops", None)
        if forced is not None:
            forced = check_integer("noops", forced, 0, 1_000_000)
        observation, info = self.env.reset(seed=seed, options=inner or None)
        again = (inner or None) if self._fire_again else {**inner, "fire": False}
        noops = draw(self.env, self.noop_min, self.noop_max + 1) - self._fires if forced is None else forced
        for _ in range(noops):
            observation, _, terminated, truncated, step_info = step_named(self.env, "NOOP")
            info.update(step_info)
            if terminated or truncated:
                observation, info = self.env.reset(seed=seed, options=again)
        return observation, info
