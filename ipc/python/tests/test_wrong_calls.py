"""No call, however wrong, ends the process or is anything but an exception."""

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import INSTANCE


@pytest.mark.parametrize("seed", range(4))
def test_only_exceptions(problems, seed, tmp_path):
    script = Path(__file__).with_name("wrong_calls.py")
    command = [sys.executable, str(script), str(seed), "1500", INSTANCE, str(problems / "rooms.json")]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert "InvalidInput" in run.stdout
