"""The numbers of the README are those that its commands print, and those of the page Validation."""

import csv
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_window_is_what_its_command_prints(command_line):
    """Line by line, as the command that stands before it prints it; lines may be left out."""
    before, block = re.search(r"(.*?)```text\n(recommended drive.*?)```", TEXT, flags=re.DOTALL).groups()
    command = re.findall(r"`gelcone (envelope [^`]*)`", before)[-1]
    code, out, _ = command_line(*command.split())
    assert code == 0
    printed = iter(out.splitlines())
    for line in block.splitlines():
        assert line in printed, f"{line!r} is not printed, or in another order; the command prints:\n{out}"


@pytest.mark.parametrize("text", ["README.md", "paper.md"])
def test_certified_numbers_are_met_as_closely_as_is_said(text):
    said = " ".join((ROOT / text).read_text(encoding="utf-8").split())
    found = re.search(r"motions to (\S+), bifurcations to (\S+), the membrane to (\d\S*\d)", said).groups()
    rows = list(csv.DictReader((ROOT / "docs" / "validation.csv").read_text(encoding="utf-8").splitlines()))
    for bound, subject, begin in zip(found, ("Motions", "Bifurcations", "Films"), ("", "", "membrane"), strict=True):
        errors = [float(row["error"]) for row in rows if row["subject"] == subject and row["number"].startswith(begin)]
        assert len(errors) > 3
        assert 1e-2 * float(bound) < max(errors) <= float(bound), f"{text}: {subject} to {bound}, not {max(errors)}"


@pytest.mark.parametrize("text", ["README.md", "paper.md"])
def test_statements_about_errors_are_those_of_the_page_validation(text):
    said = " ".join((ROOT / text).read_text(encoding="utf-8").split())
    page = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    share, runs = re.search(r"([\d.]+) % of (\d+) exponents", said).groups()
    assert re.search(rf"\| {runs} runs .* \| {share} % within one", page)
    if "random cases" in said:
        right, cases = re.search(r"right in (\d+) of (\d+) random cases", said).groups()
        assert re.search(rf"\| {cases} random motions .* \| {right} right, one flagged", page)
