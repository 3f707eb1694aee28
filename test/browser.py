"""Debian's chromium, headless, on a page of `view`."""
import shutil
import time

from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.common.by import By

LIMIT = 300.0   # [s] before a wait is a failure: a page is drawn without a graphics card
# what the page loses on purpose, and what viser's own libraries say of themselves
EXPECTED = ('ERR_CONNECTION_REFUSED', 'ERR_CONNECTION_RESET', 'WebSocket connection to')


class Browser:
    """A browser window of a size [px]; `profile` is a new folder."""

    def __init__(self, profile, width, height):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which('chromium')
        for word in ('headless=new', 'no-sandbox', 'use-angle=swiftshader',
                     'enable-unsafe-swiftshader', 'disable-quic', 'no-first-run',
                     'disable-background-networking', 'disable-component-update', 'disable-sync',
                     f'user-data-dir={profile}', f'window-size={width},{height}'):
            options.add_argument(f'--{word}')
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
        self.driver = webdriver.Chrome(
            options=options, service=webdriver.ChromeService(shutil.which('chromedriver')))
        self.driver.set_script_timeout(LIMIT)
        self._logged = []

    def open(self, url):  # noqa: A003
        # viser looks for a server that went away only while its page has the focus
        self.driver.execute_cdp_cmd('Emulation.setFocusEmulationEnabled', {'enabled': True})
        self.driver.get(url)

    def until(self, condition, what):
        """Wait until condition() is true, and return what it gives."""
        end = time.monotonic() + LIMIT
        while True:
            try:
                found = condition()
            except (WebDriverException, IndexError, TypeError, ValueError):    # drawn anew now
                found = None
            if found:
                return found
            assert time.monotonic() < end, f'{what}: not within {LIMIT} s: {self.text()}'
            time.sleep(0.2)

    def text(self):
        return self.driver.execute_script('return document.body.innerText')

    def value(self, name):
        """Return what the page says of the state, or the speed."""
        return self.driver.execute_script(
            'const e = document.querySelector(`[data-value=${arguments[0]}]`);'
            'return e && e.textContent', name)

    def sliders(self):
        return self.driver.find_elements(By.CSS_SELECTOR, '[role=slider]')

    def press(self, label):
        """Press a button, scrolled into view or not."""
        button = self.driver.find_element(
            By.XPATH, f'//button[normalize-space()="{label}"]')
        self.driver.execute_script('arguments[0].click()', button)

    def unfold(self, label):
        """Open a folder of the panel."""
        header = self.driver.find_element(By.XPATH, f'//*[normalize-space(text())="{label}"]')
        self.driver.execute_script('arguments[0].click()', header)

    def fill(self, label, text):
        """Write into the field of a form."""
        field = self.driver.find_element(
            By.XPATH, f'//form//label[normalize-space()="{label}"]/following::input[1]')
        self.driver.execute_script(
            'const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;'
            'set.call(arguments[0], arguments[1]);'
            'arguments[0].dispatchEvent(new Event("input", {bubbles: true}))', field, text)

    def log(self):
        """Return all that the console has said."""
        self._logged += self.driver.get_log('browser')
        return '\n'.join(entry['message'] for entry in self._logged)

    def errors(self):
        """Return what the console has called an error."""
        self.log()
        return [entry['message'] for entry in self._logged if entry['level'] == 'SEVERE'
                and not any(word in entry['message'] for word in EXPECTED)]

    def close(self):
        self.driver.quit()
