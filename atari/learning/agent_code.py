"""`AgentCode`: the class of an agent, one of this package or of a Python file of your own.

A run folder keeps a copy of that file, `program.py`. To load the run executes the copy, which the user must trust.
"""

import inspect
import sys
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

from atari.learning import agents
from atari.learning.agent import Agent
from atari.learning.agents import AGENTS, find_agent
from atari.learning.run import PROGRAM, RunFolder
from atari.learning.trust import check_trusted, sha256, trust
from atari.validation import check_file

_OURS = Path(agents.__file__).parent


@dataclass(frozen=True)
class AgentCode:
    """The class of an agent and the file in which it stands.

    Attributes:
        name: a name of `atari.learning.agents.AGENTS`, or the name of the file without `.py`.
        kind: the class.
        file: the path of the file; None for an agent of this package.
        source: the bytes of the file; nothing for an agent of this package.
    """

    name: str
    kind: type[Agent]
    file: Path | None = None
    source: bytes = b""


def agent_code(agent: str | Path | type[Agent]) -> AgentCode:
    """An agent by the name of one of this package, by the path of a file, or by its class.

    Args:
        agent: a name; `FILE.py`, or `FILE.py:CLASS` if the file has several agents, which is executed; or a class that
            stands in a file.

    Raises:
        FileNotFoundError: the file does not exist.
        TypeError: the class is no agent.
        ValueError: no agent has this name; the file cannot be executed, or has no agent; the class stands in no file.
    """
    if isinstance(agent, type):
        return _of_class(agent)
    text = str(agent)
    if text in AGENTS:
        return AgentCode(text, find_agent(text))
    path, colon, name = text.rpartition(":")
    if not (colon and path.endswith(".py")):
        path, name = text, ""
    if not path.endswith(".py"):
        raise ValueError(f"agent must be one of {', '.join(AGENTS)}, or a Python file such as my_ppo.py, got {text!r}")
    return _of_file(Path(path), name)


def kept_agent(run: RunFolder) -> AgentCode:
    """The agent of a run folder.

    Raises:
        PermissionError: the run has a program of its own, which the user does not trust.
        ValueError, FileNotFoundError: the program is missing, damaged or for another release.
    """
    name, entry = run.config["agent"], run.config.get("program")
    if entry is None:
        return AgentCode(name, find_agent(name))
    if not entry["class"]:
        raise ValueError(
            f"{run.path} is a run of {entry['file']}, which names no agent; "
            "RunFolder.open(...).load_weights() has its weights"
        )
    file, source = run.path / PROGRAM, run.program()
    check_trusted(file, entry["sha256"], f"{entry['file']}, class {entry['class']}")
    return AgentCode(name, _class_in(_executed(file, source), file, entry["class"]), file, source)


def _of_class(kind: type) -> AgentCode:
    if not issubclass(kind, Agent) or inspect.isabstract(kind):
        missing = ", ".join(sorted(getattr(kind, "__abstractmethods__", ())))
        raise TypeError(
            f"an agent is a class derived from atari.learning.Agent with all its methods, got {kind.__name__}"
            + (f" without {missing}" if missing else "")
        )
    try:
        file = Path(inspect.getfile(kind))
        source = file.read_bytes()
    except (TypeError, OSError):
        raise ValueError(
            f"{kind.__name__} stands in no file, and a run keeps its agent's file; write the class into a file"
        ) from None
    if file.parent == _OURS and file.stem in AGENTS:  # also if it runs as `python -m`
        return AgentCode(file.stem, kind)
    if kind.__qualname__ != kind.__name__:
        raise ValueError(f"{kind.__qualname__} stands inside of something else in {file}; move it to the file's top")
    trust(sha256(source))
    return AgentCode(file.stem, kind, file.absolute(), source)


def _of_file(file: Path, name: str) -> AgentCode:
    source = check_file(file).read_bytes()
    code = AgentCode(file.stem, _class_in(_executed(file, source), file, name), file.absolute(), source)
    trust(sha256(source))
    return code


def _executed(file: Path, source: bytes) -> ModuleType:
    """The module of a file. The bytes are executed once in a process."""
    name = f"atari_agent_{sha256(source)[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    loader = SourceFileLoader(name, str(file))
    module = module_from_spec(spec_from_loader(name, loader))  # type: ignore[arg-type]
    sys.modules[name] = module  # dataclasses look for it there
    try:
        exec(compile(source, str(file), "exec"), module.__dict__)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise ValueError(f"{_place(file, error)}: {type(error).__name__}: {error}") from error
    return module


def _place(file: Path, error: BaseException) -> str:
    """The words that begin an error of a file: an import that fails is one of another release, or a missing package."""
    if isinstance(error, ImportError) and (error.name or "").startswith("atari"):
        return f"{file} cannot be loaded; it may be for another release of atari-envs"
    return f"{file} cannot be loaded"


def _class_in(module: ModuleType, file: Path, name: str) -> type[Agent]:
    """The class of the given name, or the only agent that a file defines."""
    found = {
        key: value
        for key, value in vars(module).items()
        if isinstance(value, type) and issubclass(value, Agent) and value.__module__ == module.__name__
    }
    leaves = {
        key: value for key, value in found.items() if not any(value in other.__bases__ for other in found.values())
    }
    if name:
        leaves = {name: found[name]} if name in found else {}
    if not leaves:
        wanted = f"no agent {name}" if name else "no agent: no class derived from atari.learning.Agent"
        raise ValueError(f"{file} has {wanted}")
    if len(leaves) > 1:
        raise ValueError(f"{file} has several agents; name one of them, as in {file}:{next(iter(leaves))}")
    (kind,) = leaves.values()
    if inspect.isabstract(kind):
        missing = ", ".join(sorted(kind.__abstractmethods__))
        raise ValueError(f"{kind.__name__} in {file} lacks {missing}; it may be for another release of atari-envs")
    return kind
