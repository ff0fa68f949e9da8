"""The fixtures and settings of all tests."""

import pytest

pytest.register_assert_rewrite("core_contract", "core_tools", "env_tools", "snapshot_contract", "cli_tools")
