"""ale-py's module under another name: `import atari.ale_py as ale_py` runs programs that were written for it.

ale-py 0.12 has the same names, and `docs/ale-py.md` lists the differences. The games are played by the native core.

Example:
    >>> import atari.ale_py as ale_py
    >>> ale = ale_py.ALEInterface()
    >>> ale.setInt("random_seed", 123)
    >>> ale.setFloat("repeat_action_probability", 0.0)
    >>> ale.loadROM(ale_py.roms.get_rom_path("breakout"))
    >>> ale.reset_game()
    >>> ale.act(ale_py.Action.FIRE), ale.lives(), ale.getScreenRGB().shape
    (0, 5, (210, 160, 3))
"""

from pathlib import Path

from atari.ale_py import registration, roms
from atari.ale_py.env import AtariEnv, AtariEnvStepMetadata
from atari.ale_py.interface import ALEInterface, ALEState, LoggerMode
from atari.ale_py.registration import register_v0_v4_envs, register_v5_envs
from atari.ale_py.vector_env import ALEVectorInterface, AtariVectorEnv
from atari.cores.ale_actions import Action

__version__ = "0.12.1"
"""The version of ale-py whose interface this is."""

packagedir = str(Path(__file__).parent)
"""The folder of this module."""

SDL_SUPPORT = False
"""Whether the setting `display_screen` opens a window. Here it does not; `render_mode="human"` does."""

__all__ = [
    "SDL_SUPPORT",
    "ALEInterface",
    "ALEState",
    "ALEVectorInterface",
    "Action",
    "AtariEnv",
    "AtariEnvStepMetadata",
    "AtariVectorEnv",
    "LoggerMode",
    "register_v0_v4_envs",
    "register_v5_envs",
    "registration",
    "roms",
]
