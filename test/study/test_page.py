"""The page of a study, in a browser where there is one."""
import re
import shutil
import subprocess

from bristle_ros.study.batch import run_batch
from bristle_ros.study import store
from bristle_ros.study.measure import MEASURES
from bristle_ros.study.page import write_page
from pyarrow import parquet
import pytest

BROWSER = next(filter(None, map(shutil.which, ('chromium', 'chromium-browser', 'google-chrome'))),
               None)


def plane(study, scene):
    value = scene.road.penetration + scene.drive.mean_speed
    return dict.fromkeys(MEASURES, 0.0) | {'drive_power': value, 'settled': 'yes'}, None


@pytest.fixture
def page(study_of, tmp_path):
    study = study_of("""
vary: {road.penetration: [0.01, 0.02, 9.0], drive.mean_speed: [1.0, 2.0, 3.0]}
duration: 1.0
minimise: [drive_power]
""")
    store.begin(study, tmp_path / 'out', resume=False)
    run_batch(study, tmp_path / 'out', 0, 9, run=plane)
    return write_page(tmp_path / 'out')


def test_the_answer_comes_first(page):
    text = page.read_text(encoding='utf-8')
    body = text[text.index('<h1>'):]
    assert body.index('The smallest drive_power is 1.01') < body.index('6 finished, 3 refused')
    assert 'row 0' in body
    assert not re.search(r'(src|href)="(https?:)?//', body)


def test_a_study_of_before_a_measure_was_there_is_still_drawn(page):
    for path in (page.parent / 'runs.parquet').glob('part-*'):
        parquet.write_table(parquet.read_table(path).drop_columns(['contact_share']), path)
    assert 'The smallest drive_power is 1.01' in write_page(page.parent).read_text('utf-8')


if BROWSER:
    @pytest.mark.parametrize('width', [1280, 500])
    def test_a_browser_draws_it(page, tmp_path, width):
        done = subprocess.run(
            [BROWSER, '--headless', '--no-sandbox', '--disable-gpu', '--virtual-time-budget=20000',
             f'--user-data-dir={tmp_path}', f'--window-size={width},2000', '--dump-dom',
             page.as_uri()], capture_output=True, text=True, timeout=300)
        body = done.stdout[done.stdout.index('<h1>'):done.stdout.index('const DATA')]
        for plot in ('response', 'map', 'parallel'):
            assert re.search(rf'id="{plot}" class="js-plotly-plot"', body), plot
        assert body.count('<tr') == 1 + 9
        assert '9 of 9 rows' in body


def test_a_page_of_plots_says_the_words_first_and_needs_no_network():
    from bristle_ros.study.figures import page_of
    from plotly.graph_objects import Bar, Figure
    text = page_of('two', ['a < b'], [Figure(Bar(y=[1.0]), {'title': name})
                                      for name in ('first', 'second')])
    body = text[text.index('<h1>'):]
    assert body.index('a &lt; b') < body.index('<h2>first</h2>') < body.index('<h2>second</h2>')
    assert body.count('Plotly.newPlot(') == 2
    assert not re.search(r'(src|href)="(https?:)?//', body)


def test_what_a_measure_follows_is_said_only_as_far_as_intervals_tell():
    from bristle_ros.study.answer import _of_indices

    def index(*shares):
        return [{'key': key, 'ST': share, 'ST_ci95': width}
                for key, (share, width) in zip(('a', 'b'), shares)]
    lines = _of_indices({'normal_force_mean': index((0.8, 0.1), (0.2, 0.1)),
                         'drive_torque_mean': index((0.36, 0.22), (0.40, 0.20)),
                         'drive_power': index((0.1, 0.2), (10.0, 23.0))})
    assert 'follows a most; total shares of its variance: a 0.80 ± 0.10, b 0.20' in lines[0]
    assert 'follows b or a most' in lines[1]
    assert 'too few samples' in lines[2]
