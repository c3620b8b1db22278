# SPDX-License-Identifier: GPL-3.0-or-later
"""Headless Chromium, driven by its DevTools protocol over a pipe: messages are JSON, each ended by a zero byte."""
import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

PROGRAM = next(filter(None, map(shutil.which, ('chromium', 'chromium-browser', 'google-chrome'))), None)
KEYS = {'ArrowUp': 38, 'ArrowDown': 40, 'ArrowLeft': 37, 'ArrowRight': 39, 'Home': 36, 'End': 35, 'Escape': 27, 'Enter': 13, 'Tab': 9}


class Browser:
    """One browser. Without a graphics card Chromium draws WebGL with its own software."""

    def __init__(self):
        self.profile = tempfile.TemporaryDirectory(prefix='tetragauge_chromium_', ignore_cleanup_errors=True)
        to_browser, self.write_end = os.pipe()
        read_end, from_browser = os.pipe()
        # The browser's ends are its descriptors 3 and 4; out of the way of them first, for a descriptor that is put on
        # itself stays closed on exec.
        ends = [fcntl.fcntl(fd, fcntl.F_DUPFD, 20) for fd in (to_browser, from_browser)]
        os.close(to_browser)
        os.close(from_browser)

        def connect():
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        self.process = subprocess.Popen(
            [PROGRAM, '--headless=new', '--no-sandbox', '--remote-debugging-pipe', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
             '--no-first-run', '--disable-background-networking', '--disable-dev-shm-usage', f'--user-data-dir={self.profile.name}', 'about:blank'],
            preexec_fn=connect, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for fd in ends:
            os.close(fd)
        self.read_end = read_end
        self.buffer = b''
        self.count = 0
        self.events = []

    def close(self):
        try:
            self.call('Browser.close')
            self.process.wait(10)
        except (OSError, RuntimeError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        os.close(self.write_end)
        os.close(self.read_end)
        self.profile.cleanup()

    def read(self, deadline):
        while b'\0' not in self.buffer:
            ready, _, _ = select.select([self.read_end], [], [], max(0, deadline - time.monotonic()))
            chunk = os.read(self.read_end, 1 << 20) if ready else b''
            if not chunk:
                raise RuntimeError('Chromium has ended' if ready else 'Chromium does not answer')
            self.buffer += chunk
        message, self.buffer = self.buffer.split(b'\0', 1)
        return json.loads(message)

    def call(self, method, parameters=None, session=None, timeout_s=60):
        self.count += 1
        message = {'id': self.count, 'method': method, 'params': parameters or {}}
        if session:
            message['sessionId'] = session
        os.write(self.write_end, json.dumps(message).encode() + b'\0')
        deadline = time.monotonic() + timeout_s
        while True:
            answer = self.read(deadline)
            if answer.get('id') == self.count:
                if 'error' in answer:
                    raise RuntimeError(f'{method}: {answer["error"]["message"]}')
                return answer['result']
            self.events.append(answer)


class Page:
    """One page in a tab of its own, loaded and ready."""

    def __init__(self, browser, url, width=1400, height=900, scripts=True):
        self.browser = browser
        target = browser.call('Target.createTarget', {'url': 'about:blank'})['targetId']
        self.session = browser.call('Target.attachToTarget', {'targetId': target, 'flatten': True})['sessionId']
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.call(f'{domain}.enable')
        self.call('Emulation.setDeviceMetricsOverride', {'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': False})
        self.call('Emulation.setScriptExecutionDisabled', {'value': not scripts})
        self.call('Page.navigate', {'url': url})
        self.wait_for('document.documentElement?.dataset.ready === "yes"' if scripts else 'document.readyState === "complete" && Boolean(document.body)')

    def call(self, method, parameters=None):
        return self.browser.call(method, parameters, self.session)

    def evaluate(self, expression):
        answer = self.call('Runtime.evaluate', {'expression': expression, 'returnByValue': True, 'awaitPromise': True})
        if 'exceptionDetails' in answer:
            raise RuntimeError(f'{expression}: {answer["exceptionDetails"]}')
        return answer['result'].get('value')

    def wait_for(self, expression, timeout_s=60):
        deadline = time.monotonic() + timeout_s
        while not self.evaluate(expression):
            if time.monotonic() > deadline:
                raise RuntimeError(f'waited {timeout_s} s for {expression}; complaints: {self.complaints()}')
            time.sleep(0.05)

    def drawn(self):
        """Waits until what is asked for is on the screen."""
        self.evaluate('new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))')

    def click(self, x, y):
        for kind in ('mousePressed', 'mouseReleased'):
            self.call('Input.dispatchMouseEvent', {'type': kind, 'x': x, 'y': y, 'button': 'left', 'clickCount': 1})
        self.drawn()

    def press(self, key):
        for kind in ('keyDown', 'keyUp'):
            self.call('Input.dispatchKeyEvent', {'type': kind, 'key': key, 'code': key, 'windowsVirtualKeyCode': KEYS[key]})
        self.drawn()

    def box(self, selector):
        """Left, top, width, height in the window."""
        return self.evaluate(f'(() => {{ const b = document.querySelector({json.dumps(selector)}).getBoundingClientRect();'
                             'return [b.left, b.top, b.width, b.height]; })()')

    def pixel(self, x, y):
        """Red, green, blue of what is seen there."""
        shot = self.call('Page.captureScreenshot', {'format': 'png', 'clip': {'x': x, 'y': y, 'width': 1, 'height': 1, 'scale': 1}})['data']
        return self.evaluate(f'''(async () => {{
            const image = new Image();
            image.src = 'data:image/png;base64,{shot}';
            await image.decode();
            const context = new OffscreenCanvas(1, 1).getContext('2d');
            context.drawImage(image, 0, 0);
            return [...context.getImageData(0, 0, 1, 1).data.slice(0, 3)];
        }})()''')

    def pdf(self):
        return base64.b64decode(self.call('Page.printToPDF', {'printBackground': True})['data'])

    def own_events(self):
        return [e for e in self.browser.events if e.get('sessionId') == self.session]

    def complaints(self):
        """Exceptions, and warnings and errors of the console."""
        found = []
        for event in self.own_events():
            method, parameters = event['method'], event['params']
            if method == 'Runtime.exceptionThrown':
                found.append(parameters['exceptionDetails'].get('exception', {}).get('description', 'an exception'))
            elif method == 'Runtime.consoleAPICalled' and parameters['type'] in ('error', 'warning', 'assert'):
                found.append(str(parameters['args']))
            elif method == 'Log.entryAdded' and parameters['entry']['level'] in ('error', 'warning'):
                found.append(parameters['entry']['text'])
        return found

    def requests(self):
        urls = [e['params']['request']['url'] for e in self.own_events() if e['method'] == 'Network.requestWillBeSent']
        return [url for url in urls if not url.startswith(('data:', 'blob:'))]
