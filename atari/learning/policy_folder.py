"""The policies in a folder, of which only those are loaded that are weights, or programs that the user trusts."""

from collections.abc import Iterator
from pathlib import Path

from atari.base.extras import import_extra, install_extra
from atari.learning.policies import load_policy
from atari.learning.programs import is_trusted, sha256
from atari.policy import LoadedPolicy

ENDINGS = (".onnx", ".zip", ".pt", ".pth", ".ts")
"""The endings of files that may be policies."""


def is_policy_folder(source: str) -> bool:
    """Whether a source of policies is a folder of them, and no run folder."""
    return Path(source).is_dir() and not (Path(source) / "config.json").exists()


def policies_in(folder: Path, sample: bool = False) -> Iterator[tuple[str, LoadedPolicy | str]]:
    """The name of each entry of a folder that is a policy, and the policy, or the reason why it is not loaded.

    Entries are run folders, and files with one of `ENDINGS`; others are left out. An SB3 model or a TorchScript file
    may run any program when it is loaded, so it is not loaded from here; the user may name it alone.

    Raises:
        ValueError: no entry is a policy.
    """
    entries = [
        entry
        for entry in sorted(folder.iterdir())
        if (entry / "config.json").exists() or (entry.is_file() and entry.suffix in ENDINGS)
    ]
    if not entries:
        raise ValueError(f"{folder} has no policies: no run folders and no files {', '.join(ENDINGS)}")
    for entry in entries:
        try:
            _check_trusted(entry)
            yield entry.name, load_policy(entry, sample=sample)
        except Exception as error:  # a stranger's file may raise any; the others are loaded all the same
            yield entry.name, str(error) or type(error).__name__


def _check_trusted(entry: Path) -> None:
    """Check that to load an entry executes nothing, or only programs that the user trusts.

    Raises:
        PermissionError: the entry may be a program of a stranger.
    """
    if entry.is_file():
        if entry.suffix != ".onnx":
            raise PermissionError(
                f"{entry.name} may be a model of Stable-Baselines3, TorchScript or a pickle, and loading it may run "
                f"any program; if you trust its author, name it by itself: {entry}"
            )
        return
    import_extra("torch", f"{entry}, a run folder, needs torch: {install_extra('learn')}")
    from atari.learning.run_folder import RunFolder  # here, because it imports PyTorch

    run = RunFolder.open(entry)
    for kind in run.config.get("programs", {}):
        if not is_trusted(sha256(run.read_program(kind))):
            raise PermissionError(
                f"{run.program(kind)} is a program, which loading the run executes; if you trust its author, say so "
                f"once: atari.learning.RunFolder.open({str(entry)!r}).trust()"
            )
