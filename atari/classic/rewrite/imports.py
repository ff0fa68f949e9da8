"""Names that moved: what is imported from Gym, other names of its modules, and names that NumPy has removed."""

import ast
import importlib
import re
from functools import cache

import gymnasium
import numpy as np

from atari.classic.rewrite.making import OF_GAMES, RECORDERS, wrapper_name
from atari.classic.rewrite.script import OLD, Script, constant, normal

_NUMPY = {
    **{name: name for name in ("bool", "complex", "float", "int", "object", "str")},
    **dict.fromkeys(("Inf", "Infinity", "PINF", "infty"), "{np}.inf"),
    **{"NINF": "(-{np}.inf)", "NZERO": "-0.0", "NaN": "{np}.nan", "NAN": "{np}.nan", "PZERO": "0.0", "long": "int"},
    **{"alltrue": "{np}.all", "bool8": "{np}.bool_", "cfloat": "{np}.complex128", "complex_": "{np}.complex128"},
    **{"cumproduct": "{np}.cumprod", "float_": "{np}.float64", "longfloat": "{np}.longdouble", "unicode": "str"},
    **{"mat": "{np}.asmatrix", "product": "{np}.prod", "round_": "{np}.round", "row_stack": "{np}.vstack"},
    **{"singlecomplex": "{np}.complex64", "sometrue": "{np}.any", "string_": "{np}.bytes_", "unicode_": "{np}.str_"},
    **{"asfarray": "{np}.asarray", "in1d": "{np}.isin", "trapz": "{np}.trapezoid"},
}
"""The names of today, by the names that NumPy has removed."""
_MODULES = {
    f"{OLD}.wrappers.": f"{OLD}.wrappers",
    f"{OLD}.spaces.prng": "env.action_space.seed(0) seeds a space",
    f"{OLD}.scoreboard": "the site for results is closed",
    f"{OLD}.benchmarks": "Gym removed its benchmarks",
    f"{OLD}.envs.classic_control.rendering": "its windows are gone; return an array from render(), drawn by pygame",
    f"{OLD}.envs.atari": "the games are classes of `import atari`: atari.AtariEnv",
}
_PACKAGES = {
    "baselines": "Baselines never supported Gymnasium; its wrappers are in atari.wrappers and Stable-Baselines3",
    "gym_pull": "gym_pull is no longer maintained",
    "pybulletgym": "pybulletgym has Gym's old interface",
    "rl": "keras-rl has Gym's old interface",
    "roboschool": "Roboschool is no longer maintained; MuJoCo's environments have succeeded it",
    "stable_baselines": "Stable-Baselines3 has succeeded it",
    "universe": "Universe is no longer maintained",
}
"""Packages of Gym's time that do not work with Gymnasium."""
_LEVELS = {"DEBUG": "10", "INFO": "20", "DISABLED": "50"}
_PYTHON_2 = {"raw_input": "input", "unicode": "str", "xrange": "range"}


class Imports:
    """Rewrites imports and the names that come from them."""

    def __init__(self, script: Script, is_old: bool, careful: bool) -> None:
        self.script = script
        self.source = script.source
        self.is_old = is_old
        self.careful = careful

    def rewrite(self, needs_atari: bool) -> None:
        """Edit the imports and names; `needs_atari` adds the import that registers the games."""
        self._numpy()
        self._python_2()
        self._pickle()
        if not self.is_old:
            return
        if needs_atari and "atari" not in self.script.names:
            self.script.imports.append("import atari  # registers the Atari games")
        last: ast.stmt | None = None
        for node in self.script.walk(ast.Import, ast.ImportFrom):
            if isinstance(node, ast.Import):
                touched = [self._alias(node, alias) for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                touched = [self._import_from(node)]
            if any(touched) and last is None and isinstance(node, ast.stmt):
                last = node
        self._names()
        self._add(last)

    def _add(self, last: ast.stmt | None) -> None:
        for line in self.script.imports:
            if last is not None:
                self.source.statement_after(last, line)
            else:
                first = next(each for each in self.script.tree.body if not _is_docstring(each))
                self.source.before(first, line + self.source.newline)

    def _alias(self, node: ast.Import, alias: ast.alias) -> bool:
        """Edit `import gym` and `import gym.wrappers as wrappers`; whether it is one."""
        if self.careful:
            return alias.name == "gymnasium"
        name = alias.name.replace("atari.classic", OLD)
        if name.partition(".")[0] in _PACKAGES:
            self.script.mark(node, _PACKAGES[name.partition(".")[0]])
        if name.partition(".")[0] != OLD:
            return False
        new = _modern(name)
        if not _found(new):
            self.script.mark(node, _gone(name))
        if alias.asname:
            self.source.replace_node(alias, f"{new} as {alias.asname}")
        elif name == OLD:
            self.source.replace_node(alias, "gymnasium as gym")
        else:
            self.source.replace_node(alias, f"gymnasium as gym, {new}" if _found(new) else "gymnasium as gym")
        return True

    def _import_from(self, node: ast.ImportFrom) -> bool:
        """Edit `from gym.wrappers import Monitor`; whether it is from Gym."""
        module = normal(node.module or "")
        if module.partition(".")[0] in _PACKAGES and not node.level:
            self.script.mark(node, _PACKAGES[module.partition(".")[0]])
        if module.partition(".")[0] != OLD or node.level:
            return False
        if self.careful and all(_found(f"{node.module}.{alias.name}") for alias in node.names if alias.name != "*"):
            return True
        text = self.source.segment(node)
        match = re.match(r"from\s+([\w.]+)\s+import", text)
        if match is None:
            self.script.mark(node, "this import is not understood")
            return True
        start = self.source.start(node)
        in_wrappers = module.startswith(f"{OLD}.wrappers")
        new = "gymnasium.wrappers" if in_wrappers else _modern(module)
        if not in_wrappers and module == OLD and all(alias.name == "vector" for alias in node.names):
            new = "gymnasium"
        self.source.replace(start + match.start(1), start + match.end(1), new)
        for alias in node.names:
            self._imported(node, alias, new, in_wrappers)
        return True

    def _imported(self, node: ast.ImportFrom, alias: ast.alias, module: str, in_wrappers: bool) -> None:
        if alias.name == "*":
            return
        name = wrapper_name(alias.name) if in_wrappers else alias.name
        if in_wrappers and name == "Monitor":
            self.source.replace_node(alias, ", ".join(RECORDERS[:1] if OF_GAMES in self.script.imports else RECORDERS))
        elif not _found(f"{module}.{name}"):
            self.script.mark(node, _gone(normal(f"{node.module}.{alias.name}")))
        elif name != alias.name:
            self.source.replace_node(alias, f"{name} as {alias.asname}" if alias.asname else name)

    def _names(self) -> None:
        """Edit or mark the names of Gym's modules in the code."""
        for node in self.script.walk(ast.Name, ast.Attribute):
            name = self.script.qualified(node)
            parent = self.script.parent(node)
            if name is None or not name.startswith(f"{OLD}.") or isinstance(parent, ast.Attribute):
                continue
            if isinstance(node, ast.Name):
                last = name.rpartition(".")[2]
                if name.startswith(f"{OLD}.wrappers.") and node.id == last and wrapper_name(last) != last:
                    self.source.replace_node(node, wrapper_name(last))
                elif last in ("upload", "undo_logger_setup"):
                    self._known(node, name)
            elif not self._known(node, name) and not _found(_modern(name)):
                self.script.mark(node, _gone(name))
        for node in self.script.walk(ast.Attribute):
            name = self.script.qualified(node) or ""
            if name.startswith((f"{OLD}.envs.registry.", f"{OLD}.envs.registration.registry.")):
                self._registry(node, name.rpartition(".")[2])

    def _known(self, node: ast.AST, name: str) -> bool:
        """Edit a name that has a successor; whether it has one."""
        call, last = self.script.parent(node), name.rpartition(".")[2]
        if name.startswith(f"{OLD}.wrappers.") and (last == "Monitor" or wrapper_name(last) != last):
            return True
        if name.startswith(f"{OLD}.envs.registry") or name in (f"{OLD}.vector.make", f"{OLD}.make_vec"):
            return True
        if name.startswith(f"{OLD}.logger.") and last in _LEVELS and not (self.careful and _found(_modern(name))):
            self.source.replace_node(node, _LEVELS[last])
            return True
        if not isinstance(call, ast.Call) or call.func is not node:
            return False
        statement = self.script.parent(call)
        if last in ("set_level", "setLevel") and isinstance(statement, ast.Expr) and call.args:
            base = self.source.segment(node.value) if isinstance(node, ast.Attribute) else "gymnasium.logger"
            self.source.replace(self.source.start(call), self.source.start(call.args[0]), f"{base}.min_level = ")
            self.source.replace(self.source.end(call.args[0]), self.source.end(call), "")
            return True
        if last == "undo_logger_setup" and isinstance(statement, ast.Expr):
            self.source.delete(statement, alone=len(self.script.block(statement)) == 1)
            return True
        if last == "upload" and isinstance(statement, ast.Expr) and call.args:
            self.source.replace_node(call, f'print("The results are in", {self.source.segment(call.args[0])})')
            self.script.mark(call, "the site for results is closed; docs/modern.md says where results go now")
            return True
        return False

    def _registry(self, node: ast.AST, last: str) -> None:
        registry = self.script.modern("registry")
        call = self.script.parent(node)
        if last == "all" and isinstance(call, ast.Call):
            self.source.replace_node(call, f"{registry}.values()")
        elif last == "env_specs":
            self.source.replace_node(node, registry)
        elif last == "spec":
            self.source.replace_node(node, self.script.modern("spec"))
        elif not (self.careful and hasattr(dict, last)):
            self.script.mark(node, f"the registry is a dictionary now, and {last} is gone")

    def _numpy(self) -> None:
        for node in self.script.walk(ast.Attribute):
            name = self.script.qualified(node) or ""
            if not isinstance(node, ast.Attribute) or name != f"numpy.{node.attr}":
                continue
            new = _NUMPY.get(node.attr)
            if not isinstance(node.ctx, ast.Load):
                continue  # `np.float = float`, which scripts have for newer releases of NumPy
            if new is not None:
                self.source.replace_node(node, new.format(np=self.source.segment(node.value)))
            elif not hasattr(np, node.attr):
                self.script.mark(node, f"NumPy {np.__version__} has no {node.attr}")
            elif node.attr == "array":
                self._copy(node)

    def _copy(self, node: ast.Attribute) -> None:
        """Edit `np.array(x, copy=False)`, which meant "copy if necessary"."""
        call = self.script.parent(node)
        if not isinstance(call, ast.Call) or call.func is not node:
            return
        for given in call.keywords:
            if given.arg == "copy" and constant(given.value) is False:
                self.source.replace_node(node, f"{self.source.segment(node.value)}.asarray")
                self.source.drop_argument(call, given)

    def _pickle(self) -> None:
        """Edit `import cPickle`, which Python 3 has as `pickle`."""
        for node in self.script.walk(ast.Import, ast.ImportFrom):
            guarded = any(isinstance(each, ast.Try) for each in self.script.above(node))
            for alias in node.names if not guarded else []:  # type: ignore[attr-defined]
                if isinstance(node, ast.Import) and alias.name == "cPickle":
                    name = alias.asname or "cPickle"
                    self.source.replace_node(alias, "pickle" if name == "pickle" else f"pickle as {name}")
            if isinstance(node, ast.ImportFrom) and node.module == "cPickle" and not guarded:
                start = self.source.text.index("cPickle", self.source.start(node))
                self.source.replace(start, start + len("cPickle"), "pickle")

    def _python_2(self) -> None:
        for node in self.script.walk(ast.Name):
            if isinstance(node, ast.Name) and node.id in _PYTHON_2 and node.id not in self.script.names:
                stored = any(
                    isinstance(each, ast.Name) and each.id == node.id and isinstance(each.ctx, ast.Store)
                    for each in ast.walk(self.script.tree)
                )
                if not stored:
                    self.source.replace_node(node, _PYTHON_2[node.id])
        for node in self.script.walk(ast.Attribute):
            if isinstance(node, ast.Attribute) and node.attr in ("iteritems", "itervalues", "iterkeys", "has_key"):
                self.script.mark(node, f"Python 3 has no {node.attr}()")


def _modern(name: str) -> str:
    return "gymnasium" + name.removeprefix(OLD)


def _gone(name: str) -> str:
    """The sentence for a name that Gymnasium lacks."""
    for start, reason in _MODULES.items():
        if name.startswith(start) and not reason.startswith(OLD):
            return f"Gymnasium has no {name.removeprefix(OLD + '.')}: {reason}"
    return f"Gymnasium has no {name.removeprefix(OLD + '.')}"


@cache
def _found(name: str) -> bool:
    """Whether there is a module, or a name of one; also if it needs a package that is not installed."""
    module, _, last = name.rpartition(".")
    try:
        importlib.import_module(name)
        return True
    except ModuleNotFoundError as error:
        if error.name is not None and not f"{name}.".startswith(f"{error.name}."):
            return True
    except (ImportError, gymnasium.error.DependencyNotInstalled):
        return True
    if not module or not _found(module):
        return False
    try:
        return hasattr(importlib.import_module(module), last)
    except (ImportError, gymnasium.error.DependencyNotInstalled):
        return True


def _is_docstring(node: ast.stmt) -> bool:
    is_text = isinstance(node, ast.Expr) and isinstance(constant(node.value), str)
    return is_text or (isinstance(node, ast.ImportFrom) and node.module == "__future__")
