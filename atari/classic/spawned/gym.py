"""`import gym` in a process that a script starts by "spawn": the runner puts this folder into the module path."""

from atari.classic.__main__ import prepare

prepare()
