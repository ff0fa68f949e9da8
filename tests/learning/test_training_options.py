import pytest

from atari.learning.options import TrainingOptions, descriptions, parse


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("total_steps", "1e6", 1_000_000),
        ("stop_score", "18", 18.0),
        ("stop_score", "none", None),
        ("actions", "NOOP,LEFT", ("NOOP", "LEFT")),
        ("normalize", "true", True),
        ("game", "pong", "pong"),
    ],
)
def test_parse(name: str, text: str, value: object) -> None:
    assert parse(TrainingOptions, name, text) == value


@pytest.mark.parametrize(("name", "text"), [("total_steps", "1.5"), ("normalize", "yes"), ("gamma", "x")])
def test_parse_refuses(name: str, text: str) -> None:
    with pytest.raises(ValueError, match=r"whole number|true, false|convert"):
        parse(TrainingOptions, name, text)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"num_envs": 0}, "num_envs must be 1 or more, got 0"),
        ({"num_envs": 3, "workers": 2}, "num_envs must be a multiple of workers"),
        ({"obs": "ram"}, "network 'nature' is not for obs 'ram'"),
        ({"network": "mlp"}, "pixels need nature or small"),
        ({"obs": "sound"}, "obs must be one of pixels, ram"),
        ({"network": "resnet"}, "network must be one of nature, small"),
        ({"gamma": 1.5}, "gamma must be"),
    ],
)
def test_wrong_options(given: dict[str, object], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        TrainingOptions(**given)  # type: ignore[arg-type]


def test_every_option_is_described() -> None:
    from dataclasses import fields

    texts = descriptions(TrainingOptions)
    assert set(texts) == {field.name for field in fields(TrainingOptions)}
    assert all(len(text) > 10 and "  " not in text for text in texts.values())
