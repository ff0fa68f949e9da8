"""`ale_py.vector_env`: the vector environment, where programs import it from."""

from atari.vector import AtariVectorEnv as AtariVectorEnv
