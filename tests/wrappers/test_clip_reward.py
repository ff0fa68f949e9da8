from atari.wrappers import ClipReward


def rewards(env, steps):
    env.reset()
    return [env.step(0)[1] for _ in range(steps)]


def test_clips_to_one(scripted):
    env = ClipReward(scripted(rewards={1: 7.0, 2: -200, 3: 0.0, 4: 1, 5: 0.25, 6: -1}))
    clipped = rewards(env, 6)
    assert clipped == [1.0, -1.0, 0.0, 1.0, 0.25, -1.0]
    assert all(type(reward) is float for reward in clipped)


def test_other_bounds(scripted):
    assert rewards(ClipReward(scripted(rewards={1: 7.0, 2: -200}), -10, 5), 2) == [5.0, -10.0]
