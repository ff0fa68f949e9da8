"""The modules of Gym whose names stand in other modules here: one table in place of a file each."""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

_PACKAGE = __name__.rpartition(".")[0]

_MONITOR = {
    "monitor": "Monitor",
    "monitor_files": (
        "FILE_PREFIX MANIFEST_PREFIX capped_cubic_video_schedule clear_monitor_files collapse_env_infos "
        "detect_monitor_files detect_training_manifests disable_videos load_env_info_from_manifests load_results "
        "merge_stats_files"
    ),
    "monitor_hooks": "monitor_closer",
}

MODULES: dict[str, dict[str, str]] = {
    "benchmarks": {"scoreboard": "Benchmark BenchmarkTask benchmark_spec"},
    "configuration": {"logger": "undo_logger_setup"},
    "envs.algorithmic.copy_": {"envs.algorithmic": "CopyEnv"},
    "envs.algorithmic.duplicated_input": {"envs.algorithmic": "DuplicatedInputEnv"},
    "envs.algorithmic.repeat_copy": {"envs.algorithmic": "RepeatCopyEnv"},
    "envs.algorithmic.reverse": {"envs.algorithmic": "ReverseEnv"},
    "envs.algorithmic.reversed_addition": {"envs.algorithmic": "ReversedAdditionEnv"},
    "envs.atari.atari_env": {"envs.atari": "ACTION_MEANING AtariEnv to_ram"},
    "envs.classic_control.acrobot": {
        "envs.classic_control": "AcrobotEnv",
        "gymnasium.envs.classic_control.acrobot": "bound rk4 wrap",
    },
    "envs.classic_control.cartpole": {"envs.classic_control": "CartPoleEnv"},
    "envs.classic_control.continuous_mountain_car": {"envs.classic_control": "Continuous_MountainCarEnv"},
    "envs.classic_control.mountain_car": {"envs.classic_control": "MountainCarEnv"},
    "envs.classic_control.pendulum": {
        "envs.classic_control": "PendulumEnv",
        "gymnasium.envs.classic_control.pendulum": "DEFAULT_X DEFAULT_Y angle_normalize",
    },
    "envs.classic_control.utils": {
        "gymnasium.envs.classic_control.utils": "maybe_parse_reset_bounds verify_number_and_cast",
    },
    "envs.toy_text.blackjack": {
        "envs.toy_text": "BlackjackEnv",
        "gymnasium.envs.toy_text.blackjack": (
            "cmp deck draw_card draw_hand is_bust is_natural score sum_hand usable_ace"
        ),
    },
    "envs.toy_text.cliffwalking": {"envs.toy_text": "CliffWalkingEnv DOWN LEFT RIGHT UP"},
    "envs.toy_text.frozen_lake": {
        "envs.toy_text": "FrozenLakeEnv",
        "gymnasium.envs.toy_text.frozen_lake": "DOWN LEFT MAPS RIGHT UP generate_random_map is_valid",
    },
    "envs.toy_text.taxi": {"envs.toy_text": "TaxiEnv", "gymnasium.envs.toy_text.taxi": "MAP WINDOW_SIZE"},
    "envs.toy_text.utils": {"gymnasium.envs.toy_text.utils": "categorical_sample"},
    "monitoring": {
        "stats_recorder": "StatsRecorder",
        "video_recorder": "VideoRecorder",
        "monitor_files": "detect_training_manifests load_env_info_from_manifests load_results",
    },
    "monitoring.stats_recorder": {"stats_recorder": "StatsRecorder"},
    "monitoring.video_recorder": {"video_recorder": "ImageEncoder TextEncoder VideoRecorder touch"},
    "spaces.box": {"spaces": "Box get_inf get_precision", "gymnasium.spaces.box": "is_float_integer"},
    "spaces.dict": {"spaces": "Dict"},
    "spaces.dict_space": {"spaces": "Dict"},
    "spaces.discrete": {"spaces": "Discrete"},
    "spaces.graph": {"spaces": "Graph GraphInstance"},
    "spaces.multi_binary": {"spaces": "MultiBinary"},
    "spaces.multi_discrete": {"spaces": "MultiDiscrete"},
    "spaces.sequence": {"gymnasium.spaces": "Sequence"},
    "spaces.space": {"spaces": "Space", "gymnasium.spaces.utils": "T_cov=T"},
    "spaces.text": {"gymnasium.spaces.text": "Text alphanumeric"},
    "spaces.tuple": {"spaces": "Tuple"},
    "spaces.tuple_space": {"spaces": "Tuple"},
    "spaces.utils": {"gymnasium.spaces.utils": "FlatType T flatdim flatten unflatten", "spaces": "flatten_space"},
    "utils.atomic_write": {"monitor_files": "atomic_write replace"},
    "utils.closer": {"monitor_hooks": "Closer"},
    "utils.colorize": {"gymnasium.utils.colorize": "color2num colorize"},
    "utils.ezpickle": {"gymnasium.utils": "EzPickle"},
    "utils.json_utils": {"monitor_files": "json_encode_np"},
    "utils.passive_env_checker": {
        "gymnasium.utils.passive_env_checker": (
            "check_action_space check_obs check_observation_space check_space env_render_passive_checker "
            "env_reset_passive_checker env_step_passive_checker"
        ),
    },
    "utils.reraise_impl_py2": {"utils.reraise": "reraise_impl"},
    "utils.reraise_impl_py3": {"utils.reraise": "reraise_impl"},
    "utils.step_api_compatibility": {
        "gymnasium.utils.step_api_compatibility": (
            "DoneStepType TerminatedTruncatedStepType convert_to_done_step_api "
            "convert_to_terminated_truncated_step_api step_api_compatibility"
        ),
    },
    "vector.utils.misc": {"vector.utils": "CloudpickleWrapper clear_mpi_env_vars"},
    "vector.utils.numpy_utils": {
        "vector.utils": (
            "concatenate create_empty_array concatenate_base=concatenate concatenate_custom=concatenate "
            "concatenate_dict=concatenate concatenate_tuple=concatenate "
            "create_empty_array_base=create_empty_array create_empty_array_custom=create_empty_array "
            "create_empty_array_dict=create_empty_array create_empty_array_tuple=create_empty_array"
        ),
    },
    "vector.utils.shared_memory": {
        "vector.utils": (
            "create_shared_memory read_from_shared_memory write_to_shared_memory "
            "create_base_shared_memory=create_shared_memory create_dict_shared_memory=create_shared_memory "
            "create_tuple_shared_memory=create_shared_memory "
            "read_base_from_shared_memory=read_from_shared_memory "
            "read_dict_from_shared_memory=read_from_shared_memory "
            "read_tuple_from_shared_memory=read_from_shared_memory "
            "write_base_to_shared_memory=write_to_shared_memory "
            "write_dict_to_shared_memory=write_several_to_shared_memory "
            "write_tuple_to_shared_memory=write_several_to_shared_memory"
        ),
    },
    "vector.utils.spaces": {
        "vector.utils": (
            "BaseGymSpaces STANDARD_SPACES batch_space iterate batch_space_base=batch_space "
            "batch_space_custom=batch_space batch_space_dict=batch_space batch_space_tuple=batch_space"
        ),
    },
    "version": {"gym_ids": "VERSION"},
    "wrappers.autoreset": {"wrappers.episodes": "AutoResetWrapper"},
    "wrappers.clip_action": {"wrappers.transforms": "ClipAction"},
    "wrappers.compatibility": {"wrappers.conversions": "EnvCompatibility LegacyEnv"},
    "wrappers.env_checker": {"wrappers.conversions": "PassiveEnvChecker"},
    "wrappers.filter_observation": {"wrappers.observations": "FilterObservation"},
    "wrappers.flatten_observation": {"wrappers.transforms": "FlattenObservation"},
    "wrappers.frame_stack": {"wrappers.observations": "FrameStack LazyFrames"},
    "wrappers.frame_skipping": {"wrappers.transforms": "SkipWrapper"},
    "wrappers.gray_scale_observation": {"wrappers.transforms": "GrayScaleObservation"},
    "wrappers.human_rendering": {"wrappers.rendering": "HumanRendering"},
    "wrappers.monitor": _MONITOR,
    "wrappers.monitoring": _MONITOR,
    "wrappers.monitoring.stats_recorder": {"stats_recorder": "StatsRecorder"},
    "wrappers.monitoring.video_recorder": {"video_recorder": "ImageEncoder TextEncoder VideoRecorder touch"},
    "wrappers.order_enforcing": {"wrappers.conversions": "OrderEnforcing"},
    "wrappers.pixel_observation": {"wrappers.observations": "PixelObservationWrapper STATE_KEY"},
    "wrappers.record_episode_statistics": {
        "wrappers.episodes": "RecordEpisodeStatistics add_vector_episode_statistics"
    },
    "wrappers.render_collection": {"wrappers.rendering": "RenderCollection"},
    "wrappers.rescale_action": {"wrappers.transforms": "RescaleAction"},
    "wrappers.resize_observation": {"wrappers.transforms": "ResizeObservation"},
    "wrappers.step_api_compatibility": {"wrappers.conversions": "StepAPICompatibility"},
    "wrappers.time_aware_observation": {"wrappers.observations": "TimeAwareObservation"},
    "wrappers.time_limit": {"wrappers.episodes": "TimeLimit"},
    "wrappers.transform_observation": {"wrappers.transforms": "TransformObservation"},
    "wrappers.transform_reward": {"wrappers.transforms": "TransformReward"},
    "wrappers.vector_list_info": {"wrappers.conversions": "VectorListInfo"},
}
"""The names of a module of Gym, by the module that has them here: one of Gymnasium, or else of this package.

`name=other` has another name there.
"""


class _Finder(MetaPathFinder, Loader):
    """Makes the modules of the table."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The spec of a module of the table; None for others."""
        name = fullname.removeprefix(f"{_PACKAGE}.")
        if name not in MODULES or name == fullname:
            return None
        is_package = any(other.startswith(f"{name}.") for other in MODULES)
        return ModuleSpec(fullname, self, origin=f"{_PACKAGE}.gym_modules", is_package=is_package)

    def exec_module(self, module: ModuleType) -> None:
        homes = MODULES[module.__name__.removeprefix(f"{_PACKAGE}.")]
        for home, listed in homes.items():
            found = import_module(home if home.startswith("gymnasium.") else f"{_PACKAGE}.{home}")
            for each in listed.split():
                name, _, there = each.partition("=")
                setattr(module, name, getattr(found, there or name))
        names = " ".join(homes.values()).split()
        module.__all__ = sorted(name.partition("=")[0] for name in names)  # type: ignore[attr-defined]
        module.__doc__ = f"Gym's module of this name; its names stand in {', '.join(homes)}."


def load() -> None:
    """Import all modules of the table, as `import gym` did; a function of a module's name keeps the name."""
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.append(_Finder())
    for name in MODULES:
        parent_name, _, last = f"{_PACKAGE}.{name}".rpartition(".")
        parent = import_module(parent_name)
        before = vars(parent).get(last)
        import_module(f"{_PACKAGE}.{name}")
        if before is not None:
            setattr(parent, last, before)
