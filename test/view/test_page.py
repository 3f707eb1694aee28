"""The page in a browser, at the widths of a desk and of a phone."""
import signal

from browser import Browser
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from view.test_verb import free_port, LIMIT, view

pytestmark = pytest.mark.browser
SCENE = 'test/small_brush.yaml'


class Server:
    """`view` in a process of its own, on one port whatever happens to it."""

    def __init__(self, *arguments):
        self.port, self.process, self._arguments = free_port(), None, arguments
        self.url = f'http://127.0.0.1:{self.port}'

    def start(self):
        self.process = view(SCENE, *self._arguments, '--port', self.port)
        assert self.url in self.process.stdout.readline()

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        _, said = self.process.communicate(timeout=LIMIT)
        return self.process.returncode, said


@pytest.fixture
def server():
    made = Server()
    made.start()
    yield made
    made.end()


@pytest.fixture
def browsers(tmp_path):
    """Return a function that opens one more window."""
    opened = []

    def open_(width, height):
        opened.append(Browser(tmp_path / f'profile{len(opened)}', width, height))
        return opened[-1]

    yield open_
    for browser in opened:
        browser.close()


def speed(browser):
    return float(browser.value('speed'))


def time_of(browser):
    """Return the simulation time [s] that the page shows."""
    return float(browser.text().split('time\n')[1].split(' s')[0])


@pytest.mark.parametrize('width', [1280, 500])
def test_a_page_commands_and_comes_back(server, browsers, width):
    browser = browsers(width, 900)
    browser.open(server.url)
    browser.until(lambda: browser.value('state') == 'running', 'the brush running')
    assert speed(browser) == 5.0
    browser.until(lambda: 200.0 < float(browser.value('height')) < 230.0, 'the mount')
    slider = browser.until(browser.sliders, 'sliders')[0]
    browser.driver.execute_script('arguments[0].focus()', slider)
    for _ in range(10):
        slider.send_keys(Keys.ARROW_LEFT)
    browser.until(lambda: speed(browser) == 4.0, 'the speed of the slider')
    browser.press('Pause')
    browser.until(lambda: browser.value('state') == 'paused', 'a pause')
    held = time_of(browser)
    browser.press('One chunk')
    browser.until(lambda: time_of(browser) == pytest.approx(held + 0.005, abs=0.006)
                  and time_of(browser) > held - 1e-9, 'one chunk')
    browser.press('Reset')
    browser.until(lambda: speed(browser) == 5.0, 'the start')
    browser.press('Go on')
    browser.until(lambda: browser.value('state') == 'running', 'going on')
    browser.open(server.url)
    browser.until(lambda: browser.value('state') == 'running', 'the page, loaded again')
    assert browser.errors() == []
    assert server.end() == (0, '')
    browser.until(lambda: 'ERR_CONNECTION_REFUSED' in browser.log(), 'the loss of the server')
    lost = time_of(browser)     # it stands still; a slow page may come back later than that
    server.start()
    browser.until(lambda: 0.1 < time_of(browser) != lost, 'the server, come back')
    assert browser.errors() == []
    assert browser.driver.find_elements(By.TAG_NAME, 'canvas')


def test_a_torque_is_set_where_the_speed_is_a_result(browsers):
    """Of a free brush: from 5 rad/s towards torque / loss = 20 rad/s."""
    rules = ('contact.enabled:=false', 'drive.mode:=torque', 'drive.inertia:=0.2',
             'drive.loss:=0.05', 'drive.stall_torque:=10.0')
    server = Server(*(word for rule in rules for word in ('-p', rule)))
    server.start()
    try:
        browser = browsers(1280, 900)
        browser.open(server.url)
        browser.until(lambda: browser.value('state') == 'running', 'the brush running')
        assert 'drive torque [N m]' in browser.text()
        assert 'brush speed [rad/s]' not in browser.text()
        slider = browser.until(browser.sliders, 'sliders')[0]
        browser.driver.execute_script('arguments[0].focus()', slider)
        for _ in range(10):
            slider.send_keys(Keys.ARROW_RIGHT)
        browser.until(lambda: 15.0 < speed(browser) < 20.0, 'the speed that the torque gives')
        assert browser.errors() == []
    finally:
        assert server.end() == (0, '')


def test_pages_see_the_same_and_wrong_values_are_refused(server, browsers):
    first, second, third = (browsers(500, 500) for _ in range(3))
    for browser in (first, second, third):
        browser.open(server.url)
        browser.until(lambda shown=browser: shown.value('state') == 'running', 'the brush running')
    first.unfold('Exact values')
    first.until(lambda: 'Send' in first.text(), 'the fields')
    first.fill('brush speed [rad/s]', '1000')
    first.press('Send')
    for browser in (first, second, third):
        browser.until(lambda shown=browser: 'cmd_brush_speed: 1000 rad/s is beyond drive.max_speed'
                      in shown.text(), 'the refusal')
        assert speed(browser) == 5.0
    first.fill('brush speed [rad/s]', '7.25')
    first.press('Send')
    for browser in (first, second, third):
        browser.until(lambda shown=browser: speed(shown) == 7.25, 'the speed')
        browser.until(lambda shown=browser: 'is beyond' not in shown.text(), 'no refusal')
        assert browser.errors() == []
