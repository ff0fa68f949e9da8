"""A local cluster of Ray, in processes of its own."""

import secrets
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def cluster() -> Iterator[Any]:
    """A head without CPUs, and two nodes with three (made up) CPUs each: a `ray.cluster_utils.Cluster`, connected.

    The processes end with this one, also when it is killed. They keep nothing in the user's home folder, report nothing
    and choose free ports.
    """
    ray = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    folder = tempfile.mkdtemp(prefix="atari-ray-", dir="/tmp")  # a longer path is too long for a socket's name
    memory = 200_000_000
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", folder)  # for ~/ray_results
        patch.setenv("RAY_TMPDIR", folder)  # for RAY_TMPDIR/ray/ray_current_cluster, a folder that Ray does not make
        Path(folder, "ray").mkdir()
        patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        patch.setenv("RAY_AUTH_TOKEN", secrets.token_hex(32))
        patch.setenv("OMP_NUM_THREADS", "1")
        patch.setenv("PYTHONPATH", str(Path(__file__).parents[1] / "support"))  # workers import the tests' functions
        head = {"num_cpus": 0, "object_store_memory": memory, "include_dashboard": False, "temp_dir": folder}
        made = Cluster(initialize_head=True, head_node_args=head, shutdown_at_exit=True)
        try:
            for _ in range(2):
                made.add_node(num_cpus=3, object_store_memory=memory)
            ray.init(address=made.address, log_to_driver=False)
            yield made
        finally:
            ray.shutdown()
            made.shutdown()
            shutil.rmtree(folder, ignore_errors=True)
