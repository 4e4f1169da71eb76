"""The same tests against this process and against a daemon.

TAUT_CONFIG names the folder of shipped robots and problems, TAUT_BIN the daemon's program, TAUT_TEST_INSTANCE the
instance of a daemon that has every shipped problem loaded under its name.
"""

import os
import subprocess
import tempfile
import time
from pathlib import Path

import pytest

import taut

CONFIG = Path(os.environ["TAUT_CONFIG"])
INSTANCE = os.environ["TAUT_TEST_INSTANCE"]
PATIENCE = 60.0


@pytest.fixture(params=["local", "daemon"])
def planner(request):
    with taut.local() if request.param == "local" else taut.connect(INSTANCE) as made:
        yield made


@pytest.fixture
def daemon():
    with taut.connect(INSTANCE) as made:
        yield made


@pytest.fixture
def problems():
    return CONFIG / "problems"


class OwnDaemon:
    """A daemon that a test may kill."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory(prefix="taut")
        self.instance = f"own:{self.folder.name}/i"
        config = Path(self.folder.name, "daemon.toml")
        problem = CONFIG / "problems" / "rooms.json"
        config.write_text(
            f'fault_injection = true\n[[problems]]\nfile = "{problem}"\nrobot = "rooms"\nscene = "rooms"\n'
        )
        self.config = str(config)
        self.start()

    def start(self):
        command = [os.environ["TAUT_BIN"], "serve", "--config", self.config, "--instance", self.instance]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        until(self.is_up)

    def is_up(self):
        assert self.process.poll() is None, "the daemon ended"
        try:
            taut.connect(self.instance).close()
            return True
        except taut.DaemonLost:
            return False

    def kill(self):
        self.process.kill()
        self.process.wait()

    def end(self):
        """In order: one that was killed leaves shared memory, which the next one takes away."""
        if self.process.poll() is not None:
            self.start()
        self.process.terminate()
        self.process.wait()


@pytest.fixture
def own_daemon():
    made = OwnDaemon()
    yield made
    made.end()
    made.folder.cleanup()


def until(so):
    end = time.monotonic() + PATIENCE
    while not so():
        assert time.monotonic() < end, f"not within {PATIENCE} s"
        time.sleep(0.005)
