"""How environments are made: `make`, IDs, seeds, render modes, Monitor and the wrappers of Gym."""

import ast
import re
from functools import cached_property

from atari.classic import gym_ids
from atari.classic.rewrite.conditions import conditions, is_known
from atari.classic.rewrite.environments import Environments
from atari.classic.rewrite.script import OLD, Function, Script, constant, keyword, last_name

_ID = re.compile(r"(?:[\w.]+[:/])?[A-Z][\w-]*-v\d+")
_TEXT = re.compile(r"(FrozenLake|Taxi|CliffWalking)")
"""Environments whose picture was text in Gym."""
_RENAMED = {
    "AutoResetWrapper": "Autoreset",
    "FrameStack": "FrameStackObservation",
    "GrayScaleObservation": "GrayscaleObservation",
    "PixelObservationWrapper": "AddRenderObservation",
}
RECORDERS = ("RecordEpisodeStatistics", "RecordVideo")
"""These two wrappers of Gymnasium replace Monitor."""
OF_GAMES = "from atari.recording import RecordVideo"
"""The recorder of Atari games, which needs no MoviePy."""
_MONITOR = ("env", "video_folder", "episode_trigger")
_SOMETIMES = 'render_mode="human" shows every step from now on; make another environment for the episodes to see'


def wrapper_name(name: str) -> str:
    """The name in `gymnasium.wrappers` of a wrapper of Gym."""
    return _RENAMED.get(name, name)


def _alive(env_id: str) -> str | None:
    """An ID, or its newest version if its own is gone; None if there is none."""
    return env_id if gym_ids.is_alive(env_id) else gym_ids.newest(env_id)


def _has_mode(make: ast.Call) -> bool:
    """Whether a call of `make` has a render mode, or may have one in `**options`."""
    return any(each.arg in ("render_mode", None) for each in make.keywords)


def _monitored(call: ast.Call) -> ast.expr | None:
    """The environment of a call of `env.monitor.start`; None for other calls."""
    monitor = call.func.value if isinstance(call.func, ast.Attribute) and call.func.attr == "start" else None
    return monitor.value if isinstance(monitor, ast.Attribute) and monitor.attr == "monitor" else None


class Making:
    """Rewrites how a script makes its environments."""

    def __init__(self, script: Script, environments: Environments) -> None:
        self.script = script
        self.environments = environments
        self.source = script.source
        self.careful = environments.careful
        self._makes: list[tuple[ast.Call, str]] = []
        self._modes: dict[ast.Call, set[str]] = {}
        self._begun: set[ast.stmt] = set()
        self._windows: dict[ast.Call, list[ast.Call]] = {}
        self.needs_atari = False

    def rewrite(self) -> None:
        """Edit each call that makes, wraps, seeds or renders an environment."""
        for call in self.script.calls():
            if self.script.qualified(call.func) == f"{OLD}.make":
                self._makes.append((call, self._target(call)))
                self._modes[call] = set()
        for call in self.script.calls():
            name = self.script.qualified(call.func) or ""
            if name.startswith(f"{OLD}.wrappers.") and not name.startswith(f"{OLD}.wrappers.vector."):
                self._wrapper(call, name.rpartition(".")[2])
            elif name == f"{OLD}.vector.make" or (
                name.startswith(f"{OLD}.vector.") and self.environments.has_old_vectors()
            ):
                self._vector(call, name.rpartition(".")[2])
            elif isinstance(call.func, ast.Attribute) and call.func.attr in ("render", "seed", "start", "close"):
                self._method(call, call.func)
        for call, modes in self._modes.items():
            self._give_mode(call, modes)
        self._ids()

    def _method(self, call: ast.Call, function: ast.Attribute) -> None:
        receiver, kind = function.value, self.environments.kind(function.value)
        of = receiver.value if isinstance(receiver, ast.Attribute) and receiver.attr == "monitor" else None
        if of is not None and self.environments.kind(of) == "env":
            self._old_monitor(call, function, of)
        elif kind in ("env", "vector") and function.attr == "seed":
            if not (self.careful and (last_name(receiver) == "self" or self._is_own(receiver, "seed"))):
                self._seed(call, function)
        elif kind == "env" and function.attr == "render" and last_name(receiver) not in ("self", "super"):
            self._render(call, receiver)

    def _target(self, node: ast.AST) -> str:
        """The last identifier of the target to which an expression goes, also through calls of wrappers."""
        for parent in self.script.above(node):
            if isinstance(parent, ast.Assign):
                return last_name(parent.targets[0])
            if isinstance(parent, ast.stmt | ast.Lambda):
                break
        return ""

    def _made_for(self, env: ast.AST) -> list[ast.Call]:
        """The calls of `make` whose result an expression may be: those that the script shows, or else by its name."""
        found = self._reached(env)
        if found:
            return found
        name = last_name(env)
        same = [call for call, target in self._makes if target == name]
        free = [call for call, target in self._makes if not target]
        return same or free or [call for call, _ in self._makes]

    def _reached(self, env: ast.AST, depth: int = 8) -> list[ast.Call]:
        """The calls of `make` that an expression contains, also through names, wrappers and functions."""
        inside = [call for call, _ in self._makes if call in set(ast.walk(env))]
        if inside or depth == 0:
            return inside
        if isinstance(env, ast.Name | ast.Attribute):
            bound = self.environments.binding(env)
            return self._reached(bound[0], depth - 1) if bound is not None else []
        if not isinstance(env, ast.Call):
            return []
        function = self.environments.functions.get(last_name(env.func))
        made = [call for call, _ in self._makes if function is not None and call in set(ast.walk(function))]
        return made or (self._reached(env.args[0], depth - 1) if env.args else [])

    # Render modes.

    def _render(self, call: ast.Call, env: ast.expr) -> None:
        given = call.args[0] if call.args else getattr(keyword(call, "mode"), "value", None)
        close = keyword(call, "close")
        if close is not None and constant(close.value) is True:
            self.source.replace(self.source.end(call.func) - len("render"), self.source.end(call), "close()")
            return
        if self._is_own(env, "render"):
            return
        if self.careful and all(map(_has_mode, self._made_for(env))):
            return
        mode = "human" if given is None else constant(given)
        if not isinstance(mode, str):
            self.script.mark(call, "make() gets the render mode now (render_mode=), and render() has no argument")
            return
        self._reset_first(call, env)
        for argument in [*call.args, *call.keywords][:1]:
            self.source.replace(self.source.start(argument), self.source.end(call) - 1, "")
        makes = self._made_for(env)
        if not makes and given is not None:
            self.script.mark(call, f'give make() render_mode="{mode}" where this environment is made')
        if mode == "human" and any(_TEXT.match(str(constant(each.args[0]))) for each in makes if each.args):
            mode = "ansi"
            if isinstance(self.script.parent(call), ast.Expr):
                self.source.before(call, "print(")
                self.source.after(call, ")")
        for make in makes:
            if mode == "human" and self._needs_array(make):
                self.script.mark(call, 'this shows no window, since the environment has render_mode="rgb_array"')
            elif mode == "human":
                self._windows.setdefault(make, []).append(call)
            self._modes[make].add(mode)

    def _is_own(self, env: ast.expr, method: str) -> bool:
        """Whether an environment is of a class of the script that has a method."""
        made = self.environments.class_made(env)
        return made is not None and any(isinstance(each, Function) and each.name == method for each in made.body)

    def _reset_first(self, call: ast.Call, env: ast.expr) -> None:
        """Insert a `reset` after a `make` that `render` follows: Gymnasium renders episodes alone."""
        statement, name = self.script.statement(call), self.source.segment(env)
        block = self.script.block(statement)
        for other in reversed(block[: block.index(statement)]):
            used = [node for node in ast.walk(other) if isinstance(node, ast.Name | ast.Attribute)]
            if any(isinstance(node, ast.Attribute) and node.attr in ("reset", "seed") for node in used):
                return
            if isinstance(other, ast.Assign) and self.source.segment(other.targets[0]) == name:
                if other not in self._begun:
                    self.source.statement_after(other, f"{name}.reset()")
                self._begun.add(other)
                return

    def _needs_array(self, make: ast.Call) -> bool:
        """Whether an environment is recorded, or rendered as an array."""
        for call in self.script.calls():
            if isinstance(call.func, ast.Attribute) and call.func.attr == "render":
                values = [*call.args, *[each.value for each in call.keywords]]
                if "rgb_array" in [constant(each) for each in values] and make in self._made_for(call.func.value):
                    return True
        return self._is_recorded(make)

    def _is_recorded(self, make: ast.Call) -> bool:
        """Whether Monitor or RecordVideo records an environment."""
        for call in self.script.calls():
            name = self.script.qualified(call.func) or ""
            records = name.startswith(f"{OLD}.wrappers.") and name.endswith(("Monitor", "RecordVideo"))
            if records and call.args and make in self._made_for(call.args[0]) and not self._is_silent(call):
                return True
            env = _monitored(call)
            if env is not None and make in self._made_for(env):
                return True
        return False

    def _give_mode(self, call: ast.Call, modes: set[str]) -> None:
        if self._needs_array(call):
            modes = {"rgb_array"}
        if len(modes) > 1:
            self.script.mark(
                call, f"one environment has one render mode now; the script uses {', '.join(sorted(modes))}"
            )
        if modes and not _has_mode(call):
            condition = self._condition(call) if modes == {"human"} else ""
            self.source.add_argument(call, f'render_mode="{min(modes)}"{condition}')
        kind = keyword(call, "obs_type")
        if kind is not None and constant(kind.value) == "image":
            self.source.replace_node(kind.value, '"rgb"')

    def _condition(self, make: ast.Call) -> str:
        """The end of `render_mode="human" if render else None`: what all windows of an environment depend on."""
        windows = [conditions(self.script, call, make) for call in self._windows[make]]
        known = [
            [self.source.segment(each) for each in window if each is not None and is_known(self.script, each, make)]
            for window in windows
        ]
        common = [text for text in known[0] if all(text in texts for texts in known)]
        if all(len(window) > len(common) for window in windows):
            self.script.mark(make, _SOMETIMES)
        return f" if {' and '.join(common)} else None" if common else ""

    # Seeds.

    def _seed(self, call: ast.Call, function: ast.Attribute) -> None:
        statement = self.script.statement(call)
        if not isinstance(self.script.parent(call), ast.Expr | ast.Return | ast.ListComp):
            self.script.mark(call, "reset(seed=...) seeds an environment now, and returns no list of seeds")
            return
        reset = self._next_reset(statement, call, function)
        given = call.args[0] if call.args else getattr(keyword(call, "seed"), "value", None)
        if reset is not None and given is not None:
            self.source.add_argument(reset, f"seed={self.source.segment(given)}")
            self.source.delete(statement, alone=False)
            return
        end = self.source.end(function)
        inner = "unwrapped." if any(self._is_recorded(make) for make in self._made_for(function.value)) else ""
        self.source.replace(end - len("seed"), end, f"{inner}reset")  # a recorder takes a reset for an episode
        if call.args:
            self.source.before(call.args[0], "seed=")

    def _next_reset(self, statement: ast.stmt, call: ast.Call, function: ast.Attribute) -> ast.Call | None:
        """The `reset` that follows a `seed` without anything between that could use the environment or the seed."""
        env, block = self.source.segment(function.value), self.script.block(statement)
        given = call.args[0] if call.args else None
        if not isinstance(self.script.parent(call), ast.Expr) or not isinstance(given, ast.Constant | ast.Name):
            return None
        if not (self.source.begins_line(statement) and self.source.ends_line(statement)):
            return None
        for other in block[block.index(statement) + 1 :]:
            value = other.value if isinstance(other, ast.Assign | ast.Expr) else None
            if isinstance(value, ast.Call) and self.environments.is_reset(value):
                same = isinstance(value.func, ast.Attribute) and self.source.segment(value.func.value) == env
                return value if same and not (value.args or value.keywords) else None
            used = {self.source.segment(node) for node in ast.walk(other) if isinstance(node, ast.Name | ast.Attribute)}
            spaces = {f"{env}.action_space", f"{env}.observation_space"}
            stored = isinstance(other, ast.Assign) and isinstance(given, ast.Name) and given.id in used
            if not isinstance(other, ast.Assign | ast.Expr) or stored or (env in used and not used & spaces):
                return None
        return None

    # Monitor and the other wrappers.

    def _sibling(self, function: ast.expr, name: str) -> str:
        """The text for another name of the module of a name."""
        if isinstance(function, ast.Name):
            return name
        base = function.value if isinstance(function, ast.Attribute) else function
        if self.script.qualified(base) == f"{OLD}.wrappers":
            return f"{self.source.segment(base)}.{name}"
        return self.script.modern(f"wrappers.{name}")

    def _is_silent(self, monitor: ast.Call) -> bool:
        """Whether a Monitor records no videos."""
        given = monitor.args[2] if len(monitor.args) > 2 else getattr(keyword(monitor, "video_callable"), "value", None)
        return constant(given) is False

    def _wrapper(self, call: ast.Call, name: str) -> None:
        if not call.args:
            self.script.mark(call, f"{name} needs the environment as its first argument")
            return
        if name == "Monitor":
            self._monitor(call)
            return
        if name == "RecordVideo":
            for make in self._made_for(call.args[0]):
                self._modes[make].add("rgb_array")
        if name in _RENAMED and not isinstance(call.func, ast.Name):
            self.source.replace_node(call.func, self._sibling(call.func, _RENAMED[name]))
        stack, rows, lz4 = (keyword(call, each) for each in ("num_stack", "deque_size", "lz4_compress"))
        for argument, new in ((stack, "stack_size"), (rows, "buffer_length")):
            if argument is not None:
                self.source.replace(self.source.start(argument), self.source.start(argument.value), f"{new}=")
        if lz4 is not None:
            self.source.drop_argument(call, lz4)
        if name == "ResizeObservation":
            self._resize(call)
        elif name == "TransformObservation" and len(call.args) + len(call.keywords) == 2:
            self.source.add_argument(call, "None")

    def _resize(self, call: ast.Call) -> None:
        given = call.args[1] if len(call.args) > 1 else getattr(keyword(call, "shape"), "value", None)
        if isinstance(constant(given), int) and given is not None:
            text = self.source.segment(given)
            self.source.replace_node(given, f"({text}, {text})")
        elif not isinstance(given, ast.Tuple):
            self.script.mark(call, "ResizeObservation takes the shape (rows, columns), not one number")

    def _monitor(self, call: ast.Call) -> None:
        env, source = call.args[0], self.source
        silent = self._is_silent(call)
        statistics = self._sibling(call.func, RECORDERS[0])
        if silent:
            source.replace_node(call.func, statistics)
            for argument in [*call.args[1:], *call.keywords]:
                source.drop_argument(call, argument)
            self.script.mark(call, 'the statistics are in info["episode"] of an episode\'s last step, not in files')
            return
        source.replace_node(call.func, self._recorder(call, self._sibling(call.func, "RecordVideo")))
        source.before(env, f"{statistics}(")
        source.after(env, ")")
        for argument in call.args[3:]:
            source.drop_argument(call, argument)
        for given in call.keywords:
            new = {"directory": _MONITOR[1], "video_callable": _MONITOR[2]}.get(given.arg or "")
            if new is not None:
                source.replace(source.start(given), source.start(given.value), f"{new}=")
            elif given.arg is not None:
                source.drop_argument(call, given)
        makes = self._made_for(env)
        if not makes:
            self.script.mark(call, 'give make() render_mode="rgb_array" where this environment is made')

    def _recorder(self, monitor: ast.Call, gymnasiums: str) -> str:
        """The text for the class that records videos: that of the Atari games if the script records them alone."""
        if not self._records_games:
            self.script.mark(monitor, "RecordVideo needs MoviePy: pip install moviepy")
            return gymnasiums
        if OF_GAMES not in self.script.imports:
            self.script.imports.append(OF_GAMES)
        return "RecordVideo"

    @cached_property
    def _records_games(self) -> bool:
        recorded: list[ast.Call] = []
        for call in self.script.calls():
            name = self.script.qualified(call.func) or ""
            is_monitor = name.startswith(f"{OLD}.wrappers.") and name.endswith(".Monitor") and not self._is_silent(call)
            env = call.args[0] if is_monitor and call.args else _monitored(call)
            if env is not None:
                recorded += self._made_for(env) or [call]
        ids = [constant(make.args[0]) if make in self._modes and make.args else ... for make in recorded]
        alive = [_alive(each) if isinstance(each, str) else None for each in ids]
        games = all(each is not None and gym_ids.is_ours(each) for each in alive)
        return games and "RecordVideo" not in self.script.names

    def _old_monitor(self, call: ast.Call, function: ast.Attribute, env: ast.expr) -> None:
        """Edit `env.monitor.start(folder)` and `env.monitor.close()` of 2016."""
        name, source = self.source.segment(env), self.source
        if function.attr == "close":
            source.replace_node(call, f"{name}.close()")
        elif function.attr == "start" and isinstance(self.script.parent(call), ast.Expr) and call.args:
            video = self._recorder(call, self.script.modern("wrappers.RecordVideo"))
            statistics = self.script.modern(f"wrappers.{RECORDERS[0]}")
            chosen = keyword(call, "video_callable")
            trigger = f", episode_trigger={source.segment(chosen.value)}" if chosen is not None else ""
            folder = source.segment(call.args[0])
            source.replace_node(call, f"{name} = {video}({statistics}({name}), {folder}{trigger})")
        else:
            self.script.mark(call, "env.monitor is gone; wrap the environment in RecordVideo")

    # Vectors.

    def _vector(self, call: ast.Call, name: str) -> None:
        mode = self.script.modern("vector.AutoresetMode.SAME_STEP")
        if name in ("SyncVectorEnv", "AsyncVectorEnv") and keyword(call, "autoreset_mode") is None:
            self.source.add_argument(call, f"autoreset_mode={mode}")
        elif name == "make":
            self.source.replace_node(call.func, self.script.modern("make_vec"))
            given = keyword(call, "asynchronous")
            value = call.args[2] if len(call.args) > 2 else given.value if given is not None else None
            text = '"sync"' if constant(value) is False else '"async"'
            if value is not None and not isinstance(value, ast.Constant):
                text = f'"async" if {self.source.segment(value)} else "sync"'
            if value is None:
                self.source.add_argument(call, f"vectorization_mode={text}")
            else:
                self.source.replace_node(given or value, f"vectorization_mode={text}")
            self.source.add_argument(call, f'vector_kwargs={{"autoreset_mode": {mode}}}')

    # IDs.

    def _ids(self) -> None:
        for node in self.script.walk(ast.Constant):
            value = constant(node)
            if (
                not isinstance(value, str)
                or not _ID.fullmatch(value)
                or isinstance(self.script.parent(node), ast.JoinedStr)
            ):
                continue
            made = isinstance(call := self.script.parent(node), ast.Call) and call in self._modes
            self._id(node, value, made)
        for call, _ in self._makes:
            self.needs_atari |= bool(call.args) and constant(call.args[0]) is ... and not self.careful
        if self.careful and {"ale_py", "atari"} & {each.partition(".")[0] for each in self.script.names.values()}:
            self.needs_atari = False

    def _id(self, node: ast.AST, value: str, made: bool) -> None:
        new = _alive(value)
        if new is None:
            fate = gym_ids.fate(value)
            if made and fate is not None:
                self.script.mark(node, f"there is no {value}: {fate}")
            return
        self.needs_atari |= gym_ids.is_ours(new)
        if new != value:
            quote = self.source.segment(node)[0]
            self.source.replace_node(node, f"{quote}{new}{quote}")
