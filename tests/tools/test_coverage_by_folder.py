"""The summary of the coverage adds up files by folder."""

import runpy
from pathlib import Path

SCRIPT = runpy.run_path(str(Path(__file__).parents[2] / "tools" / "coverage_by_folder.py"))


def file(ran, lines):
    return {"summary": {"covered_lines": ran, "num_statements": lines}}


def test_files_are_added_up_by_folder_and_the_whole_is_last():
    counted = SCRIPT["by_folder"](
        {
            "files": {
                "src/gelcone/errors.py": file(3, 4),
                "src/gelcone/physics/laws.py": file(10, 10),
                "src\\gelcone\\physics\\film\\taut.py": file(20, 30),
            }
        }
    )
    assert counted == {".": (3, 4), "physics/": (30, 40)}
    assert SCRIPT["table"](counted).splitlines()[-1].split() == ["all", "75.0", "%", "of", "44", "lines"]
