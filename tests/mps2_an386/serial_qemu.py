# SPDX-License-Identifier: GPL-3.0-or-later
"""A QEMU with an image, its serial line on a socket; its processor waits for the first host. Whatever is waited for here is
certain to come on a machine however busy: the limits are there to name what hangs."""
import os
import shutil
import subprocess
import tempfile
import time

PATIENCE_S = 300  # some thousand times what these take on a machine that does nothing else


class SerialQemu:
    def __init__(self, machine, image, *options):
        self.folder = tempfile.mkdtemp(prefix='tetragauge-')
        socket = os.path.join(self.folder, 'line')
        self.port = 'unix:' + socket
        # Not a pipe: nobody reads it while the machine runs.
        with open(os.path.join(self.folder, 'said'), 'wb') as said:
            self.qemu = subprocess.Popen(['qemu-system-arm', '-M', machine, '-display', 'none', '-monitor', 'none', '-kernel', image, *options,
                                          '-serial', f'unix:{socket},server=on,wait=on'], stdin=subprocess.DEVNULL, stdout=said, stderr=said)
        ends = time.monotonic() + PATIENCE_S
        while not os.path.exists(socket):
            if self.qemu.poll() is not None or time.monotonic() > ends:
                why = f'QEMU has not opened its serial line; exit code {self.qemu.poll()}; it said: {self.said()}'
                self.end()
                raise AssertionError(why)
            time.sleep(0.02)

    def said(self):
        """By QEMU, until now."""
        with open(os.path.join(self.folder, 'said'), encoding='utf-8', errors='replace') as file:
            return file.read()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()

    def end(self):
        self.qemu.kill()
        self.qemu.wait()
        shutil.rmtree(self.folder)

    def run_host(self, *command):
        """A host's program, to its end. `tetragauge` gives a machine 3 s for a sign of life, which one that waits for its turn on
        this computer may exceed: then it is run again. With a machine that hangs it ends so every time."""
        ends = time.monotonic() + PATIENCE_S
        while True:
            left = ends - time.monotonic()
            try:
                done = subprocess.run(command, capture_output=True, text=True, timeout=max(left, 1), check=False)
            except subprocess.TimeoutExpired as error:
                raise AssertionError(f'{command} has not ended after {PATIENCE_S} s') from error
            if done.returncode != 4:
                return done
            if self.qemu.poll() is not None or time.monotonic() > ends:
                raise AssertionError(f'{command} reaches no machine, for {PATIENCE_S} s or because QEMU has ended ({self.qemu.poll()}): {done.stderr}')
