"""The README's Python runs as it stands, in the root of the repository."""

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


def test_python_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "python" / "README.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == 3
    (tmp_path / "examples").mkdir()
    for name in ("mine.yaml", "mine.png"):
        shutil.copy(ROOT / "examples" / name, tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    # One program: later blocks use the names of earlier ones.
    names: dict[str, Any] = {}
    exec("".join(blocks), names)
    assert names["drive"].figures["controller"] == "careful"
    assert names["drive"].reached
    printed = capsys.readouterr().out.splitlines()
    assert printed[-2].startswith("1. inbye: ")
    pattern = r"2\. careful: \S+, difference -\S+, too few worlds to tell"
    assert re.fullmatch(pattern, printed[-1])
    assert (tmp_path / "comparison" / "index.html").exists()
