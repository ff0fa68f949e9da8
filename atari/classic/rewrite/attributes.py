"""Attributes of environments and specs that moved, and methods of their random numbers."""

import ast

from atari.classic.rewrite.environments import Environments
from atari.classic.rewrite.script import OLD, Function, Script, last_name

_MOVED = {"nS": "observation_space.n", "nA": "action_space.n", "_max_episode_steps": "spec.max_episode_steps"}
_API = frozenset(
    "action_space close env get_wrapper_attr has_wrapper_attr metadata monitor np_random observation_space render "
    "render_mode reset seed set_wrapper_attr spec step unwrapped configure".split()
)
"""Attributes that Gymnasium's wrappers have, or other parts of the rewriting edit."""
_INSIDE = frozenset(
    "P ale clone_full_state clone_state desc get_action_meanings get_keys_to_action getRamState lives ncol nrow "
    "restore_full_state restore_state s state theta".split()
)
"""Attributes of the environments of Gym and of Atari games, which wrappers no longer forward."""
_SPEC = {"timestep_limit": "max_episode_steps"}
_SPEC_GONE = frozenset("tags trials local_only _kwargs _entry_point".split())
_RANDOM = {"randint": "integers", "random_sample": "random", "rand": "random", "randn": "standard_normal"}
_RANDOM_GONE = frozenset("seed get_state set_state random_integers tomaxint".split())
_TAG = "wrapper_config.TimeLimit.max_episode_steps"


class Attributes:
    """Rewrites attributes of environments."""

    def __init__(self, script: Script, environments: Environments) -> None:
        self.script = script
        self.environments = environments
        self.source = script.source
        self._own = self._find_own()

    def _find_own(self) -> set[str]:
        """The attributes that classes of the script define."""
        stored = {
            node.attr
            for node in self.script.walk(ast.Attribute)
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and last_name(node.value) == "self"
        }
        methods = {each.name for owner in self.environments.classes for each in owner.body if hasattr(each, "name")}
        return stored | methods

    def rewrite(self) -> None:
        """Edit each attribute of an environment, of a spec and of random numbers, and each registration."""
        for node in self.script.walk(ast.Attribute):
            if not isinstance(node, ast.Attribute):
                continue
            if last_name(node.value) == "np_random":
                self._random(node)
            elif self._is_spec(node.value):
                self._spec(node)
            elif self.environments.kind(node.value) == "env" and not self._is_self(node.value):
                self._attribute(node)
        for call in self.script.calls():
            name = self.script.qualified(call.func) or ""
            if name.startswith(f"{OLD}.") and name.endswith("register"):
                self._register(call)
        for each in self.script.walk(ast.Constant):
            if getattr(each, "value", None) == "ale.lives" and isinstance(
                self.script.parent(each), ast.Subscript | ast.Call
            ):
                self.source.replace_node(each, '"lives"')

    def _is_own(self, node: ast.Attribute) -> bool:
        """Whether an attribute is of an instance of a class of the script that has it, or may have it."""
        made = self.environments.class_made(node.value)
        if made is None or self.environments.classes[made] != "wrapper":
            return made is not None
        defined = {each.name for each in made.body if isinstance(each, Function)}
        for each in ast.walk(made):
            if isinstance(each, ast.Name | ast.Attribute) and isinstance(each.ctx, ast.Store):
                defined.add(last_name(each))
        is_plain = all(self.script.qualified(base) is not None for base in made.bases)
        return node.attr in defined or not is_plain

    def _is_self(self, node: ast.AST) -> bool:
        return last_name(node) in ("self", "cls") or (isinstance(node, ast.Call) and last_name(node.func) == "super")

    def _is_spec(self, node: ast.AST) -> bool:
        if isinstance(node, ast.Attribute) and node.attr == "spec":
            return self.environments.kind(node.value) == "env"
        return isinstance(node, ast.Call) and self.script.qualified(node.func) == f"{OLD}.spec"

    def _is_wrong(self, node: ast.Attribute) -> bool:
        """Whether a script for Gymnasium cannot have an attribute: its environment comes from `make` directly."""
        bound = self.environments.binding(node.value) if isinstance(node.value, ast.Name | ast.Attribute) else None
        made = bound[0] if bound is not None else node.value
        if not isinstance(made, ast.Call) or self.script.qualified(made.func) != f"{OLD}.make":
            return node.attr in ("nS", "nA")
        return node.attr in _INSIDE or node.attr in ("nS", "nA", "reward_range")

    def _attribute(self, node: ast.Attribute) -> None:
        inner = isinstance(node.value, ast.Attribute) and node.value.attr == "unwrapped"
        name = node.attr
        if self.environments.careful and not self._is_wrong(node):
            return
        if name in _MOVED and isinstance(node.ctx, ast.Load):
            self._rename(node, _MOVED[name])
        elif name == "_max_episode_steps":
            self.script.mark(node, "make(..., max_episode_steps=...) changes the time limit now")
        elif name == "reward_range":
            if isinstance(node.ctx, ast.Load):
                self.source.replace_node(node, '(-float("inf"), float("inf"))')
            self.script.mark(node, "environments have no reward_range now; Gym's was infinite unless a class set it")
        elif name in ("get_episode_rewards", "get_episode_lengths"):
            self._statistics(node, "return_queue" if name.endswith("rewards") else "length_queue")
        elif name in ("_get_image", "_get_ram"):
            method = "getScreenRGB" if name == "_get_image" else "getRAM"
            self._rename(node, f"{'' if inner else 'unwrapped.'}ale.{method}")
        elif name == "configure":
            self.script.mark(node, "environments have no configure(); make() takes the options")
        elif inner or name in _API or self._is_own(node):
            return
        elif name in _INSIDE and name not in self._own:
            self._rename(node, f"unwrapped.{name}")
        elif isinstance(node.ctx, ast.Load):
            self._rename(node, f'get_wrapper_attr("{name}")')
        else:
            self.script.mark(node, f"this sets {name} of the outermost wrapper alone, as wrappers hide what they wrap")

    def _name_start(self, node: ast.Attribute) -> int:
        """The offset of an attribute's name, before which the text of its object has edits of its own."""
        return self.source.end(node) - len(node.attr)

    def _rename(self, node: ast.Attribute, new: str) -> None:
        self.source.replace(self._name_start(node), self.source.end(node), new)

    def _statistics(self, node: ast.Attribute, queue: str) -> None:
        """Edit `env.get_episode_rewards()` of Monitor."""
        call = self.script.parent(node)
        if isinstance(call, ast.Call):
            self.source.before(call, "list(")
            self.source.replace(self._name_start(node), self.source.end(call), f'get_wrapper_attr("{queue}"))')
            self.script.mark(node, "these are the last 100 episodes; RecordEpisodeStatistics takes a buffer_length")

    def _spec(self, node: ast.Attribute) -> None:
        outer = self.script.parent(node)
        call = self.script.parent(outer) if outer is not None else None
        if node.attr in _SPEC:
            self._rename(node, _SPEC[node.attr])
        elif node.attr == "tags" and any(getattr(each, "value", None) == _TAG for each in ast.walk(call or node)):
            whole = call if isinstance(call, ast.Call) else outer
            self.source.replace(self._name_start(node), self.source.end(whole or node), "max_episode_steps")
        elif node.attr in _SPEC_GONE:
            self.script.mark(node, f"a spec has no {node.attr} now")

    def _random(self, node: ast.Attribute) -> None:
        """Edit a method of RandomState, which is a NumPy Generator now."""
        if self.environments.careful and "np_random" in self._own:
            return  # it may be a RandomState of the script
        if node.attr in _RANDOM_GONE:
            self.script.mark(node, f"np_random is a numpy.random.Generator now, which has no {node.attr}()")
        call, new = self.script.parent(node), _RANDOM.get(node.attr)
        if new is None or not isinstance(call, ast.Call):
            return
        self._rename(node, new)
        if node.attr in ("rand", "randn") and call.args:
            self.source.before(call.args[0], "(")
            self.source.after(call.args[-1], ",)" if len(call.args) == 1 else ")")

    def _register(self, call: ast.Call) -> None:
        for given in call.keywords:
            if given.arg == "timestep_limit":
                self.source.replace(self.source.start(given), self.source.start(given.value), "max_episode_steps=")
            elif given.arg == "tags" and isinstance(given.value, ast.Dict):
                limits = zip(given.value.keys, given.value.values, strict=True)
                limit = [value for key, value in limits if getattr(key, "value", None) == _TAG]
                if limit:
                    self.source.replace_node(given, f"max_episode_steps={self.source.segment(limit[0])}")
                else:
                    self.source.drop_argument(call, given)
            elif given.arg in ("trials", "local_only"):
                self.source.drop_argument(call, given)
            elif given.arg == "entry_point":
                text = self.source.segment(given.value)
                self.source.replace_node(given.value, text.replace("gym.envs", "gymnasium.envs", 1))
