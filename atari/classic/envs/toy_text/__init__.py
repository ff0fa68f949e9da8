"""Environments with finitely many states, and their base."""

from atari.classic.envs.toy_text import discrete
from atari.classic.envs.toy_text.blackjack import BlackjackEnv
from atari.classic.envs.toy_text.cliffwalking import CliffWalkingEnv
from atari.classic.envs.toy_text.frozen_lake import FrozenLakeEnv
from atari.classic.envs.toy_text.taxi import TaxiEnv

__all__ = ["BlackjackEnv", "CliffWalkingEnv", "FrozenLakeEnv", "TaxiEnv", "discrete"]
