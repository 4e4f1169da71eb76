"""The examples of the documentation run."""

import doctest
import re
from pathlib import Path

import pytest
from conftest import CONFIG

import taut
import taut._answers
import taut._planner
import taut._scene

HERE = Path(__file__).parents[1] / "README.md"
PROJECT = Path(__file__).parents[3]
MORE = [page for page in sorted(PROJECT.glob("docs/*.md")) if "```python\n" in page.read_text()]


@pytest.mark.parametrize("module", [taut, taut._planner, taut._scene, taut._answers])
def test_docstrings(module):
    names = {"ROBOTS": str(CONFIG / "robots"), "PROBLEMS": str(CONFIG / "problems")}
    failed, tried = doctest.testmod(module, extraglobs=names)
    assert failed == 0 and (tried > 0 or module is taut._answers)


@pytest.mark.parametrize("page", [HERE, PROJECT / "README.md", *MORE], ids=lambda page: page.name)
def test_every_block_of_a_page_runs(page, monkeypatch, tmp_path):
    monkeypatch.chdir(CONFIG.parent)
    monkeypatch.setenv("TAUT_INSTANCE", __import__("conftest").INSTANCE)
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(), re.S)
    assert blocks
    names = {"RESULT": str(tmp_path / "result.json")}
    for block in blocks:
        block = block.replace('"result.json"', "RESULT")
        exec(compile(block, str(page), "exec"), names)
    assert (tmp_path / "result.json").is_file() == ('"result.json"' in "".join(blocks))


def test_everything_is_documented():
    for name in taut.__all__:
        thing = getattr(taut, name)
        assert thing.__doc__, name
        for member, value in vars(thing).items():
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert value.__doc__, f"{name}.{member}"
