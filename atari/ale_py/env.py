"""`ale_py.env`: the environment, where programs import it from."""

from atari.env import AtariEnv as AtariEnv
