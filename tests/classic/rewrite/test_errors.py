"""The errors of old scripts on Gymnasium are in the documentation, word for word."""

import gymnasium
import numpy as np
import pytest
from documents import page
from env_tools import needs_gymnasium_1

ERRORS = {
    "a, b, c, d = env.step(0)": "too many values to unpack",
    "env.reset().shape": "no attribute 'shape'",
    "np.zeros((16, 4))[gym.make('FrozenLake-v1').reset(), :]": "only integers",
    "env.reset()[::2, ::2]": "tuple indices",
    "hash(gym.make('FrozenLake-v1').reset())": "unhashable",
    "np.reshape(env.reset(), [1, 4])": "inhomogeneous shape",
    "env.seed(0)": "no attribute 'seed'",
    "env.env.seed(0)": "no attribute 'seed'",
    "env.render(mode='rgb_array')": "unexpected keyword argument 'mode'",
    "env.render('rgb_array')": "positional argument",
    "gym.wrappers.RecordVideo(env, 'x')": "Render mode is None",
    "gym.make('CartPole-v1').render()": "before calling",
    "gym.wrappers.Monitor(env, 'x')": "no attribute 'Monitor'",
    "from gymnasium.wrappers import Monitor": "cannot import name",
    "env.monitor": "no attribute 'monitor'",
    "from gymnasium.wrappers import FrameStack": "cannot import name",
    "gym.make('FrozenLake-v0')": "deprecated",
    "env.env.get_action_meanings()": "no attribute 'get_action_meanings'",
    "type('W', (gym.ObservationWrapper,), {'_observation': lambda self, o: o})(env).reset()": "^$",
    "gym.spaces.prng.seed(0)": "no attribute 'prng'",
    "import cPickle": "cPickle",
    "env.ale": "no attribute 'ale'",
    "env.nS": "no attribute 'nS'",
    "env.reward_range": "no attribute 'reward_range'",
    "env.spec.timestep_limit": "no attribute 'timestep_limit'",
    "gym.envs.registry.all()": "no attribute 'all'",
    "gym.logger.set_level(40)": "no attribute 'set_level'",
    "env.np_random.randint(3)": "no attribute 'randint'",
    "np.bool8": "no attribute 'bool8'",
    "np.float": "no attribute 'float'",
    "np.Inf": "np.Inf",
    "np.array([1], copy=False)": "Unable to avoid copy",
    "env.step(0)[4]['ale.lives']": "ale.lives",
    "env.step(0)[4]['TimeLimit.truncated']": "TimeLimit.truncated",
    "gym.upload('x')": "no attribute 'upload'",
}
NUMPY_2 = ("np.bool8", "np.Inf", "np.array([1], copy=False)")


@needs_gymnasium_1
@pytest.mark.parametrize("line", ERRORS)
def test_an_error_is_in_the_documentation(line: str) -> None:
    if line in NUMPY_2 and np.lib.NumpyVersion(np.__version__) < "2.0.0":
        pytest.skip("the names are removed in NumPy 2")
    env = gymnasium.make("CartPole-v1")
    env.reset(seed=0)
    with pytest.raises(Exception, match=ERRORS[line]) as raised:
        exec(line, {"gym": gymnasium, "np": np, "env": env})
    said = f"{raised.type.__name__}: {raised.value}"
    documented = [row.split("|")[1].strip().strip("`").strip() for row in page("modern.md") if row.startswith("| `")]
    assert any(said.startswith(text) for text in documented), said
