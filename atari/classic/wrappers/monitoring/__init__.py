"""The recorder of videos, in Gym's place, and `Monitor` in that of 2017."""

from atari.classic.wrappers.monitor import (
    FILE_PREFIX,
    MANIFEST_PREFIX,
    Monitor,
    capped_cubic_video_schedule,
    clear_monitor_files,
    collapse_env_infos,
    detect_monitor_files,
    detect_training_manifests,
    disable_videos,
    load_env_info_from_manifests,
    load_results,
    merge_stats_files,
    monitor_closer,
)

__all__ = [
    "FILE_PREFIX",
    "MANIFEST_PREFIX",
    "Monitor",
    "capped_cubic_video_schedule",
    "clear_monitor_files",
    "collapse_env_infos",
    "detect_monitor_files",
    "detect_training_manifests",
    "disable_videos",
    "load_env_info_from_manifests",
    "load_results",
    "merge_stats_files",
    "monitor_closer",
]
