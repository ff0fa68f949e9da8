"""`ale_py.vector_env`: the vector environment, where programs import it from, and its raw interface."""

from os import PathLike

from atari.ale_py.interface import id_of_rom
from atari.env import AtariEnv as AtariEnv
from atari.vector import AtariVectorEnv as AtariVectorEnv
from atari.vector.ale_interface import AleVectorInterface

_NAMES = {"frame_skip": "frameskip", "max_episode_steps": "max_num_frames_per_episode"}
"""Names of options that `AtariVectorEnv` calls otherwise. As in ale-py, `max_episode_steps` counts frames."""
_NO_OPTIONS = ("self", "rom_path", "num_envs", "__class__")


class ALEVectorInterface(AleVectorInterface):
    """The environments of a vector, made from a ROM file.

    The options are those of `AtariVectorEnv`, except `frame_skip` for `frameskip`, and `max_episode_steps` for
    `max_num_frames_per_episode`.

    Raises:
        AleError: there is no such ROM file, or it is the ROM of no game.
        TypeError, ValueError: see `AtariVectorEnv`.

    Example:
        >>> import atari.ale_py as ale_py
        >>> envs = ale_py.ALEVectorInterface(ale_py.roms.get_rom_path("pong"), 2)
        >>> observations, info = envs.reset([0, 1], [3, 4])
        >>> envs.send([0, 1], [1.0, 1.0])
        >>> observations, rewards, terminations, truncations, info = envs.recv()
        >>> observations.shape, envs.get_num_envs()
        ((2, 4, 84, 84), 2)
    """

    def __init__(
        self,
        rom_path: str | PathLike[str],
        num_envs: int,
        frame_skip: int = 4,
        stack_num: int = 4,
        img_height: int = 84,
        img_width: int = 84,
        grayscale: bool = True,
        maxpool: bool = True,
        noop_max: int = 30,
        use_fire_reset: bool = True,
        episodic_life: bool = False,
        life_loss_info: bool = False,
        reward_clipping: bool = True,
        max_episode_steps: int = 108_000,
        repeat_action_probability: float = 0.0,
        full_action_space: bool = False,
        batch_size: int = 0,
        num_threads: int = 0,
        thread_affinity_offset: int = -1,
        autoreset_mode: str = "NextStep",
    ) -> None:
        given = {name: value for name, value in locals().items() if name not in _NO_OPTIONS}
        options = {_NAMES.get(name, name): value for name, value in given.items()}
        super().__init__(AtariVectorEnv(id_of_rom(rom_path), num_envs, rom=rom_path, **options))
