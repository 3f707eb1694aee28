#!/usr/bin/env python3
"""
Make README's first pictures: ./run.sh tools/picture_of_view.py docs/view.jpg [SCENE.yaml | LOG].

Starts `view` and looks at it with Debian's chromium (apt install chromium chromium-driver), which
needs no graphics card. Wants what ./test.sh installs: run that, or its first lines, before.
"""
from pathlib import Path
import subprocess
import sys
import tempfile
import time

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / 'test')]

from browser import Browser  # noqa: E402
from PIL import Image  # noqa: E402

SIZE = 1440, 900
PORT = '8099'
SETTLED = 7.0   # [s] of simulation time after which curves fill their charts


def main():
    """Take the picture."""
    target = Path(sys.argv[1])
    view = subprocess.Popen([sys.executable, '-m', 'bristle_ros', 'view', *sys.argv[2:], '--port',
                             PORT], stdout=subprocess.PIPE, text=True)
    try:
        view.stdout.readline()
        with tempfile.TemporaryDirectory() as profile:
            browser = Browser(profile, *SIZE)
            browser.open(f'http://127.0.0.1:{PORT}')
            browser.until(lambda: browser.value('state') in ('running', 'playing'), 'a brush')
            browser.until(lambda: float(browser.text().split('time\n')[1].split(' s')[0])
                          > SETTLED, 'full charts')
            browser.driver.execute_script(  # that there is no graphics card here is no news
                'document.querySelectorAll(".mantine-Notifications-root").forEach('
                'e => e.style.display = "none")')
            time.sleep(0.5)
            browser.until(lambda: browser.driver.save_screenshot(
                str(target.with_suffix('.full.png'))), 'a picture')    # a busy machine is slow
            browser.close()
    finally:
        view.terminate()
        view.wait()
    with Image.open(target.with_suffix('.full.png')) as picture:
        picture.convert('RGB').save(target, quality=80, optimize=True)
    target.with_suffix('.full.png').unlink()
    print(f'{target}: {target.stat().st_size} bytes')


if __name__ == '__main__':
    main()
