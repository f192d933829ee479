"""--film of every command: fitted films of other versions are refused in one line, and so are unknown ones."""

import pytest

from gelcone.devices.files import shipped_devices

GONE = "is a fitted film of gelcone 0.1 or 0.2, which is not read any more; take film = membrane, the"


@pytest.mark.parametrize("subject", [["biased-pump"], ["--preset", "table1", "--set", "voltage=0.5"]])
@pytest.mark.parametrize(
    ("film", "message"),
    [
        ("continuum", GONE),
        ("/no/such/film.json", GONE),
        ("wrinklin", "did you mean 'wrinkling'?"),
    ],
)
def test_a_film_that_is_not_read_is_refused_in_one_line(command_line, subject, film, message):
    code, out, err = command_line("simulate", *subject, "--film", film)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_a_device_file_of_0_2_with_a_fitted_film_is_refused_with_its_line(command_line, tmp_path):
    text = shipped_devices()["biased-pump"].read_text(encoding="utf-8").partition("[material]")
    (tmp_path / "mine.toml").write_text(f'{text[0]}film = "film.json"\n{text[1]}{text[2]}')
    code, out, err = command_line("simulate", tmp_path / "mine.toml")
    assert (code, out) == (2, "")
    assert GONE in err
    assert "line" in err
    assert err.count("\n") == 1
