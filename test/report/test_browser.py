"""The report's page in a browser: wide, and as narrow as a telephone."""
import shutil

import pytest

OPTIONS = ('--headless=new', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
           '--disable-background-networking', '--disable-component-update', '--disable-sync')
# What stands out of the page, and is not inside something that scrolls.
WIDE = """
return [...document.querySelectorAll('body *')].filter(element =>
    element.getBoundingClientRect().right > innerWidth + 1 && !element.closest('.scroll, pre, svg')
).map(element => element.outerHTML.slice(0, 80));
"""
EMPTY = """
return [...document.querySelectorAll('.panels svg')].filter(figure => {
    const box = figure.getBoundingClientRect();
    return box.width < 200 || box.height < 100 || figure.querySelectorAll('text').length < 4;
}).length;
"""
SMALL = """
return Math.min(...[...document.querySelectorAll('.panels svg text')].map(
    text => text.getBoundingClientRect().height));
"""

pytestmark = pytest.mark.browser


@pytest.fixture(scope='module')
def address(page, tmp_path_factory):
    return page.write(tmp_path_factory.mktemp('page')).as_uri()


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    from selenium import webdriver
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which('chromium')
    for option in (*OPTIONS, f'--user-data-dir={tmp_path_factory.mktemp("profile")}'):
        options.add_argument(option)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    made = webdriver.Chrome(options, webdriver.ChromeService(shutil.which('chromedriver')))
    yield made
    made.quit()


def load(browser, address):
    """Load the page, all of it: on a busy machine parts were missing when `get` came back."""
    from selenium.webdriver.support.wait import WebDriverWait
    browser.get(address)
    WebDriverWait(browser, 60).until(
        lambda browser: browser.execute_script('return document.readyState') == 'complete')


@pytest.mark.parametrize('width', [500, 1280])
def test_the_page_is_legible(browser, address, width):
    browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
        'width': width, 'height': 900, 'deviceScaleFactor': 1, 'mobile': False})
    load(browser, address)
    assert browser.execute_script('return innerWidth') == width
    browser.execute_script('document.querySelectorAll("details").forEach(d => d.open = true)')
    assert browser.execute_script(
        'return document.documentElement.scrollWidth <= innerWidth')
    assert browser.execute_script(WIDE) == []
    assert browser.execute_script('return document.querySelectorAll(".panels svg").length') >= 6
    assert browser.execute_script(EMPTY) == 0
    assert browser.execute_script(SMALL) >= 8.0     # [px]
    assert browser.get_log('browser') == []


def test_tables_sort_and_anchors_lead_somewhere(browser, address):
    load(browser, address)
    assert browser.execute_script("""
        return [...document.querySelectorAll('a[href^="#"]')].filter(
            link => !document.getElementById(link.hash.slice(1))).map(link => link.hash);""") == []
    rows = """
        const table = document.querySelector('table[aria-label^="What each feature costs"]');
        table.querySelectorAll('th button')[1].click();
        return [...table.tBodies[0].rows].map(row => parseFloat(row.cells[1].dataset.value));"""
    values = [value for value in browser.execute_script(rows) if value is not None]
    assert len(values) > 5
    assert values == sorted(values)
    down = [value for value in browser.execute_script(rows) if value is not None]
    assert down == values[::-1]


def test_the_check_can_fail(browser, address):
    load(browser, address)
    browser.execute_script('document.body.insertAdjacentHTML("beforeend", '
                           '"<p style=\\"width: 3000px\\">wide</p>")')
    assert browser.execute_script(WIDE)
