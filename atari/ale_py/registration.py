"""`ale_py.registration`: IDs for Gymnasium's registry."""

from atari.registry.registration import register_ids
from atari.task.env_ids import ids, stem


def rom_id_to_name(rom: str) -> str:
    """The name of a game in its IDs.

    Example:
        >>> from atari.ale_py.registration import rom_id_to_name
        >>> rom_id_to_name("ms_pacman")
        'MsPacman'
    """
    return stem(rom)


def register_v5_envs() -> None:
    """Register the IDs of ALE's v5; `import atari` has done that already.

    Example:
        >>> import gymnasium
        >>> import atari.ale_py as ale_py
        >>> ale_py.register_v5_envs()
        >>> "ALE/Pong-v5" in gymnasium.registry
        True
    """
    register_ids(env_id for env_id in ids() if env_id.endswith("-v5"))


def register_v0_v4_envs() -> None:
    """Register the IDs of the versions 0 and 4; `import atari` has done that already.

    Example:
        >>> import gymnasium
        >>> import atari.ale_py as ale_py
        >>> ale_py.register_v0_v4_envs()
        >>> "PongNoFrameskip-v4" in gymnasium.registry
        True
    """
    register_ids(env_id for env_id in ids() if env_id.endswith(("-v0", "-v4")))
