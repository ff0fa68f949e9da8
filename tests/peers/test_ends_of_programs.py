"""Programs of Stable-Baselines3 and SuperSuit run to their end, and nothing of this package is left then."""

import pytest
from own_process import REPORTING, printed_at_end

pytestmark = pytest.mark.peers

ENDS = {
    "a training": """
        import atari, torch
        from stable_baselines3 import PPO
        from atari.sb3 import AtariVecEnv
        torch.set_num_threads(1)
        envs = AtariVecEnv("pong", 2, preset="baselines")
        model = PPO("CnnPolicy", envs, n_steps=8, batch_size=8, n_epochs=1, device="cpu").learn(32)
    """,
    "single environments": """
        import atari
        from stable_baselines3.common.env_util import make_atari_env
        envs = make_atari_env("PongNoFrameskip-v4", n_envs=2)
        envs.reset()
    """,
    "processes": """
        import atari
        from stable_baselines3.common.env_util import make_atari_env
        from stable_baselines3.common.vec_env import SubprocVecEnv
        envs = make_atari_env("PongNoFrameskip-v4", n_envs=2, vec_env_cls=SubprocVecEnv,
                              vec_env_kwargs={"start_method": "fork"})
        envs.reset()
        envs.close()
    """,
    "SuperSuit": """
        import supersuit
        from atari.multiplayer import parallel_env
        env = supersuit.pettingzoo_env_to_vec_env_v1(parallel_env("pong_v3"))
        envs = supersuit.concat_vec_envs_v1(env, 2, num_cpus=0, base_class="gymnasium")
        envs.reset(seed=0)
    """,
    "EnvPool's interface": """
        import atari.integrations.envpool as ours
        envs = ours.make("Pong-v5", env_type="gymnasium", num_envs=2)
        envs.reset()
    """,
}


@pytest.mark.parametrize("name", ENDS)
def test_nothing_is_left(name: str) -> None:
    program = REPORTING + "".join(line.removeprefix("        ") + "\n" for line in ENDS[name].splitlines())
    assert "nanobind" not in printed_at_end(program)
