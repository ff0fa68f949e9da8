"""`load_policy`: a policy from a run folder, a file, the name of a function, or an object.

Files are models of Stable-Baselines3, TorchScript and ONNX. Each format needs its package.
"""

import sys
import zipfile
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base import json_text
from atari.base.archives import check_member, read_member
from atari.base.extras import import_extra, install_extra, pip_install
from atari.base.typed_table import check_type
from atari.base.validation import check_file
from atari.policy import (
    NO_ENVIRONMENT,
    Accepted,
    Array,
    LoadedPolicy,
    Policy,
    ScoresPolicy,
    describe,
    is_network,
    makes_policy,
    takes_lanes,
)

_KINDS = "a run folder, an SB3 zip, a TorchScript or ONNX file, or module:name"
_SB3_VERSION = "_stable_baselines3_version"
_MOST_UNPACKED = 64 << 20


def load_policy(source: Any, *, sample: bool = False) -> LoadedPolicy:
    """Load a policy. All functions and commands with a policy accept the same sources.

    SB3 zips, TorchScript files and functions are programs: load them only from trusted authors (see docs/trust.md).

    Args:
        source: one of

            - "random" or "noop";
            - a run folder of `atari train`;
            - a model that Stable-Baselines3 has saved (.zip): PPO, A2C, DQN, QR-DQN (with sb3-contrib). It gets the
              images of preset "baselines", or RAM, as its observation space says;
            - a TorchScript file, which may contain the policy's `environment` as an extra file "environment.json";
            - an ONNX file (.onnx). The metadata "environment", JSON, is the policy's `environment`; without it, the
              shape of the input decides the images;
            - "module:name", the name of an object as below; modules in the current folder are found, too;
            - a `torch.nn.Module`, which may have the attributes of a `Policy`;
            - a `Policy`, or a function of observations alone;
            - a class of these that is made without arguments, or a function without parameters that returns one.

            Networks are called in their evaluation mode with uint8 observations (n, ...), and return scores
            (n, actions), floats, or actions (n,), integers.
        sample: draw actions with the probabilities softmax(scores) of a network, instead of the highest score.

    Returns:
        The policy, a function of observations and lanes. Its format decides which of `scores`, `values`,
        `probabilities`, `features` and `network` it has, see `ScoresPolicy` and the table in docs/evaluation.md.

    Raises:
        FileNotFoundError: the file or folder does not exist.
        TypeError: the object is no policy.
        ValueError: the source is no policy, or is damaged; or `sample` is given for a policy without probabilities.
        gymnasium.error.DependencyNotInstalled: a package is needed that is not installed; the text names it.

    Example:
        >>> from atari.learning import evaluate, load_policy
        >>> policy = load_policy("random")
        >>> evaluate(policy, "pong", "dopamine", episodes=1).policy
        'random'
    """
    if not isinstance(source, (str, Path)):
        return source if isinstance(source, LoadedPolicy) and not sample else LoadedPolicy(_of_object(source, sample))
    text, path = str(source), Path(source)
    if text in ("random", "noop"):
        return LoadedPolicy(_of_object(_Random if text == "random" else _Noop, sample))
    if path.is_dir():
        return LoadedPolicy(_run_folder(path, sample))
    if isinstance(source, str) and ":" in text and not path.exists():
        try:
            return LoadedPolicy(_of_object(import_named(text, f"policy {text}"), sample))
        except TypeError as error:
            raise ValueError(f"policy {text} cannot be used: {error}") from error
    return LoadedPolicy(_file(path, sample))


def import_named(name: str, owner: str) -> Any:
    """The object with the name "module:name"; modules of the current folder are found, too.

    Raises:
        ValueError: the object does not exist. The error begins with `owner`.
    """
    module, _, attribute = name.partition(":")
    if module.endswith(".py"):
        raise ValueError(f"{owner} is named by its module: {Path(module).stem}:{attribute}, from the module's folder")
    sys.path.insert(0, "")  # modules of this folder, as with `python -m`
    try:
        return getattr(import_module(module), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(f"{owner} cannot be imported: {error}") from error
    finally:
        sys.path.remove("")


def _of_object(source: Any, sample: bool) -> Policy:
    if makes_policy(source):
        try:
            source = source()
        except TypeError as error:
            raise TypeError(f"{source.__name__} cannot be made without arguments, give an instance: {error}") from error
    if is_network(source) and not takes_lanes(source):
        return _network(source, type(source).__name__, sample)
    if sample:
        name = getattr(source, "name", source)
        raise ValueError(f"sample=True draws actions with the probabilities of a network, and {name} has none")
    return source


def _run_folder(folder: Path, sample: bool) -> Policy:
    if not (folder / "config.json").is_file():  # this error needs no PyTorch
        raise ValueError(f"{folder} is no run folder of `atari train`: it has no config.json")
    _need("torch", f"{folder}, a run folder,", install_extra("learn"))
    from atari.learning.run_policy import run_policy

    return run_policy(folder, sample)


class _Random(ScoresPolicy):
    """A policy with uniformly random actions."""

    def __init__(self) -> None:
        super().__init__(np.asarray, sample=True, name="random")
        self._methods = set()  # it only draws

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> Array:
        generators = [self.generator(lane) for lane in lanes.tolist()]
        count = len(self._begun[1]) if self._begun else 0
        return np.array([generator.integers(count) for generator in generators], np.int64)


class _Noop:
    """A policy that always plays NOOP."""

    name, sample = "noop", False
    _noop: int | None = None

    def begin(self, game: str, actions: Sequence[str], lanes: Array, seeds: Array) -> None:
        if "NOOP" not in actions:
            raise ValueError(
                f"{game} has no NOOP; its actions are {', '.join(actions)}; actions='full' (--actions full) adds it"
            )
        self._noop = actions.index("NOOP")

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> Array:
        if self._noop is None:
            raise ValueError(
                "noop needs the names of the actions; call begin(game, actions, lanes, seeds) before it plays"
            )
        return np.full(len(lanes), self._noop)


def _file(file: Path, sample: bool) -> Policy:
    """The policy in a file. The ending .onnx decides for ONNX; the content decides for all other kinds."""
    if not file.exists():
        raise FileNotFoundError(
            f"there is no file {file}; a policy is random, noop, {_KINDS}; or, in commands, a replay"
        )
    check_file(file)
    if file.suffix == ".onnx":
        return _onnx(file, sample)
    if not zipfile.is_zipfile(file):
        raise ValueError(f"{file} is no policy: give {_KINDS}")
    try:
        with zipfile.ZipFile(file) as archive:
            _check_unpacked(archive, file.stat().st_size)
            names = archive.namelist()
            data = read_member(archive, "data", _MOST_UNPACKED) if _SB3_VERSION in names else None
    except (zipfile.BadZipFile, RuntimeError, ValueError, OSError) as error:
        raise ValueError(f"{file} is damaged: {error}") from error
    if data is not None:
        facts = json_text.parse(data, f"{file}: its data", most_bytes=_MOST_UNPACKED)
        return _sb3(file, check_type(facts, f"{file}: its data", dict), sample)
    if any("/code/" in name for name in names):
        return _torch_script(file, sample)
    if any(name.endswith("/data.pkl") for name in names):
        raise ValueError(
            f"{file} has weights without a network; give the run folder that it is in, or a TorchScript file"
        )
    raise ValueError(f"{file} is a zip archive, but neither a model of Stable-Baselines3 nor a TorchScript file")


def _check_unpacked(archive: zipfile.ZipFile, size: int) -> None:
    """Refuse an archive that libraries would unpack to more than 64 MiB and 32 bytes for each byte of it."""
    left = _MOST_UNPACKED + 32 * size
    for info in archive.infolist():
        check_member(info, left)
        left -= info.file_size


def _need(module: str, what: str, install: str) -> Any:
    return import_extra(module, f"{what} needs {module}: {install}")


def _sb3(file: Path, facts: Mapping[str, Any], sample: bool) -> Policy:
    """A model of Stable-Baselines3, without the parts that only its training needs."""
    _need("stable_baselines3", f"{file}, a model of Stable-Baselines3,", install_extra("sb3"))
    module, name = _algorithm(file, facts)
    algorithm = getattr(_need(module, f"{file}, a model of {name},", pip_install("sb3-contrib")), name)
    unused = {
        "learning_rate": 0.0,
        "lr_schedule": _zero,
        "clip_range": _zero,
        "clip_range_vf": None,
        "exploration_schedule": _zero,
        "buffer_size": 1,
        "optimize_memory_usage": False,
        "replay_buffer_class": None,
        "tensorboard_log": None,
    }
    try:
        model = algorithm.load(file, device="cpu", custom_objects={key: unused[key] for key in unused if key in facts})
        model.policy.set_training_mode(False)
        scores, actions = _sb3_scores(model, name), int(model.action_space.n)
    except Exception as error:  # pickles raise errors of all kinds
        raise ValueError(f"{file} cannot be loaded as a model of {name}: {error}") from error
    environment = _of_space(file, model.observation_space, actions)
    steps = facts.get("num_timesteps")
    logits = name in ("PPO", "A2C")
    if sample and not logits:
        raise ValueError(f"{file} is a model of {name}, which has no probabilities of actions; leave sample=True out")
    return ScoresPolicy(
        scores,
        sample=sample,
        accepted=_accepted(model.observation_space),
        logits=logits,
        values=_sb3_values(model) if logits else lambda observations: scores(observations).max(1),
        features=_last_hidden(model.policy, scores),
        network=model.policy,
        name=f"{name} ({file.name})",
        environment=environment,
        training_frames=4 * int(steps) if isinstance(steps, int) and steps > 0 else None,
    )


def _accepted(space: Any) -> Accepted:
    """The observations of a model: Stable-Baselines3 takes images with their channels first or last."""
    shape = tuple(space.shape)
    return Accepted((shape, (*shape[1:], shape[0]), (shape[2], *shape[:2])) if len(shape) == 3 else (shape,), dtype="")


def _zero(_: float) -> float:
    return 0.0


def _algorithm(file: Path, facts: Mapping[str, Any]) -> tuple[str, str]:
    """The module and the class of a model, found by its fields: Stable-Baselines3 does not store the name."""
    policy = facts.get("policy_class")
    module = str(policy.get("__module__", "")) if isinstance(policy, dict) else ""
    if "qrdqn" in module:
        return "sb3_contrib", "QRDQN"
    if "exploration_fraction" in facts:
        return "stable_baselines3", "DQN"
    if "clip_range" in facts:
        return "stable_baselines3", "PPO"
    if "gae_lambda" in facts:
        return "stable_baselines3", "A2C"
    raise ValueError(
        f"{file} is a model of Stable-Baselines3, but not of PPO, A2C, DQN or QR-DQN (its policy: {module})"
    )


def _sb3_scores(model: Any, name: str) -> Any:
    torch = import_module("torch")
    policy = model.policy

    def scores(observations: Any) -> Any:
        tensor, _ = policy.obs_to_tensor(observations)
        with torch.no_grad():
            if name in ("PPO", "A2C"):
                return policy.get_distribution(tensor).distribution.logits.numpy()
            if name == "DQN":
                return policy.q_net(tensor).numpy()
            return policy.quantile_net(tensor).mean(dim=1).numpy()

    return scores


def _sb3_values(model: Any) -> Any:
    """The function that returns the values of an actor-critic."""
    torch = import_module("torch")

    def values(observations: Any) -> Any:
        tensor, _ = model.policy.obs_to_tensor(observations)
        with torch.no_grad():
            return model.policy.predict_values(tensor)[:, 0].numpy()

    return values


def _last_hidden(network: Any, scores: Any) -> Any:
    from atari.learning.hidden import last_hidden  # here, because it imports PyTorch

    return last_hidden(network, scores)


def _of_space(file: Path, space: Any, actions: int) -> dict[str, Any]:
    options: dict[str, Any] = {"preset": "baselines", "full_action_space": actions == 18}
    shape = getattr(space, "shape", None)
    if shape == (128,):
        return options | {"obs_type": "ram"}
    if shape is None or len(shape) != 3 or space.dtype != np.uint8:
        raise ValueError(f"{file} was trained on observations that are no images and no RAM: {space}")
    last = shape[2] < shape[0]
    stack, height, width = (shape[2], *shape[:2]) if last else shape
    return options | {"stack_num": stack, "img_height": height, "img_width": width, "channels_last": last}


def _torch_script(file: Path, sample: bool) -> Policy:
    torch = _need("torch", f"{file}, a TorchScript file,", install_extra("learn"))
    extra = {"environment.json": ""}
    try:
        module = torch.jit.load(str(file), map_location="cpu", _extra_files=extra)
    except RuntimeError as error:
        raise ValueError(f"{file} is no TorchScript file, or damaged: {_first_line(error)}") from error
    return _network(module, file.name, sample, environment=_environment(file, extra["environment.json"]))


_NETWORK_ATTRIBUTES = ("name", "task", "environment", "game", "protocol", "training_frames")
"""Attributes of a policy that a network may have."""


def _network(module: Any, name: str, sample: bool, **facts: Any) -> ScoresPolicy:
    """The policy of a network of PyTorch, whose training mode is the same after each call."""
    torch = import_module("torch")
    own = {key: getattr(module, key) for key in _NETWORK_ATTRIBUTES if getattr(module, key, None) is not None}
    facts = {"name": name, **own, **facts}
    parameter = next(module.parameters(), None)

    def tensors(observations: Any) -> Any:
        if isinstance(observations, dict):
            return {key: tensors(value) for key, value in observations.items()}
        if not isinstance(observations, np.ndarray) or observations.dtype.kind not in "biuf":
            got = describe(observations) if isinstance(observations, np.ndarray) else type(observations).__name__
            raise TypeError(
                f"{facts['name']} takes observations as a NumPy array of numbers, or a dict of them, got {got}"
            )
        tensor = torch.from_numpy(observations)
        return tensor if parameter is None else tensor.to(parameter.device)

    def scores(observations: Any) -> Any:
        given = tensors(observations)
        training = [part for part in module.modules() if part.training]
        module.eval()
        try:
            with torch.no_grad():
                returned = module(given)
        except (AttributeError, LookupError, RuntimeError, TypeError) as error:
            raise _failed(facts, observations, error) from error
        finally:
            for part in training:
                part.training = True
        if not torch.is_tensor(returned):
            got = type(returned).__name__
            raise ValueError(f"{facts['name']} must return one tensor, of scores or of actions, got {got}")
        returned = returned.cpu()
        return returned.float().numpy() if returned.is_floating_point() else returned.numpy()

    return ScoresPolicy(scores, sample=sample, features=_last_hidden(module, scores), network=module, **facts)


def _failed(facts: Mapping[str, Any], observations: Any, error: Exception) -> ValueError:
    missing = "" if facts.get("task") or facts.get("environment") else NO_ENVIRONMENT
    return ValueError(
        f"{facts['name']} cannot be computed on observations {describe(observations)}: {_first_line(error)}; a network "
        f"takes observations as its task or environment says, and divides them by 255 itself{missing}"
    )


def _first_line(error: Exception) -> str:
    return str(error).strip().partition("\n")[0]


def _onnx(file: Path, sample: bool) -> Policy:
    onnxruntime = _need("onnxruntime", f"{file}, an ONNX file,", pip_install("onnxruntime"))
    try:
        session = onnxruntime.InferenceSession(file.read_bytes(), providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's classes of errors are not public
        raise ValueError(f"{file} is no ONNX file, or damaged: {error}") from error
    if len(session.get_inputs()) != 1:
        raise ValueError(f"{file} must have one input, has {len(session.get_inputs())}")
    (entry,) = session.get_inputs()
    dtype = {"tensor(uint8)": np.uint8, "tensor(float)": np.float32}.get(entry.type)
    if dtype is None:
        raise ValueError(f"{file} must take uint8 or float, takes {entry.type}")

    def scores(observations: Any) -> Any:
        try:
            return session.run(None, {entry.name: np.ascontiguousarray(observations, dtype)})[0]
        except Exception as error:  # onnxruntime's classes of errors are not public
            raise _failed({"name": file.name, "environment": environment}, observations, error) from error

    stored = session.get_modelmeta().custom_metadata_map.get("environment", "")
    environment = _environment(file, stored) or _of_shape(entry.shape)
    fixed = len(entry.shape) > 1 and all(isinstance(size, int) for size in entry.shape[1:])
    accepted = Accepted((tuple(entry.shape[1:]),), dtype="") if fixed else None
    return ScoresPolicy(scores, sample=sample, accepted=accepted, name=file.name, environment=environment)


def _of_shape(shape: list[Any]) -> dict[str, Any]:
    """The options of an environment whose observations fit the shape of an input; {} if its sizes are not fixed."""
    if shape[1:] == [128]:
        return {"obs_type": "ram"}
    if len(shape) == 4 and all(isinstance(size, int) for size in shape[1:]):
        return {"stack_num": shape[1], "img_height": shape[2], "img_width": shape[3]}
    return {}


def _environment(file: Path, text: str | bytes) -> dict[str, Any]:
    if not text:
        return {}
    options = json_text.parse(text, f"{file}: its environment")
    if not isinstance(options, dict):
        raise ValueError(f"{file}: its environment must be an object of options, got {options!r}")
    return options
