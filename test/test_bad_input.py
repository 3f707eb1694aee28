"""Unusable input in short: see test/faults/bad_input.py, which does all of it."""
from pathlib import Path
import sys

sys.path.append(str(Path(__file__).resolve().parent / 'faults'))
import bad_input


def test_unusable_input_is_one_line_and_loses_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = []
    counts, codes = bad_input.run(tmp_path, every=50, step=5, show=said.append)
    assert said == []
    assert counts['cases'] >= 200
    assert counts['processes'] >= 4
    assert set(codes) <= {0, 1, 2, 3}
    assert codes[2] > 0.9 * counts['cases']


def test_the_check_sees_what_it_is_there_to_see(tmp_path):
    case = bad_input.Case('a case', ())
    assert bad_input.problem_of(case, 2, 'scene: wrong\n') == ''
    assert bad_input.problem_of(case, 2, 'scene: wrong\n and more\n').startswith('not one line')
    assert bad_input.problem_of(case, 0, '') == 'exit code 0'
    assert bad_input.problem_of(case, 1, 'Traceback\nE: x\n') == 'traceback: E: x'
    assert bad_input.in_process(['scene', str(tmp_path / 'none.yaml')])[0] == 2
