# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the built programs as a person would, each test in a folder of its own."""
import json
import math
import os
import subprocess
import tempfile
import unittest

ROOT = os.environ.get('TETRAGAUGE_ROOT', os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..')))
BIN = os.environ.get('TETRAGAUGE_BIN', os.path.join(ROOT, 'build', 'release', 'bin'))
SHARED = os.path.join(os.path.dirname(ROOT), 'shared')  # data by others; not part of the project
NOMINAL = os.path.join(ROOT, 'examples', 'staircase', 'nominal.csg')


def needs_shared(path):
    return unittest.skipUnless(os.path.exists(os.path.join(SHARED, path)),
                               f'needs {path} in the folder shared/ beside the checkout')


class CommandLineTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix='tetragauge_')
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, content):
        with open(self.path(name), 'wb') as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return self.path(name)

    def read(self, name):
        with open(self.path(name), 'rb') as file:
            return file.read()

    def run_command(self, *arguments, timeout=300):
        """Runs tetragauge; the finished process, whatever its exit code."""
        command = [os.path.join(BIN, 'tetragauge'), *map(str, arguments)]
        return subprocess.run(command, cwd=self.folder, capture_output=True, timeout=timeout, text=True, check=False)

    def run_json(self, *arguments, codes=(0,), timeout=300):
        """Runs tetragauge with --json -; what it wrote on stdout, parsed."""
        done = self.run_command(*arguments, '--json', '-', '--quiet', timeout=timeout)
        self.assertIn(done.returncode, codes, done.stderr)
        return json.loads(done.stdout)


def rotation_from_degrees(x_deg, y_deg, z_deg):
    """Rz Ry Rx."""
    x, y, z = (math.radians(a) for a in (x_deg, y_deg, z_deg))
    cx, sx, cy, sy, cz, sz = math.cos(x), math.sin(x), math.cos(y), math.sin(y), math.cos(z), math.sin(z)
    return [[cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx]]


def move(rotation, translation, p):
    return [sum(rotation[i][k] * p[k] for k in range(3)) + translation[i] for i in range(3)]


def rotation_angle_deg(a, b):
    """Angle of a b^T: from the norm of its skew part, exact for small angles."""
    r = [[sum(a[i][k] * b[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    skew = math.sqrt((r[2][1] - r[1][2])**2 + (r[0][2] - r[2][0])**2 + (r[1][0] - r[0][1])**2)
    return math.degrees(math.atan2(skew / 2, (r[0][0] + r[1][1] + r[2][2] - 1) / 2))


def main():
    """unittest.main, and a line for ctest when every test of the file was skipped."""
    program = unittest.main(verbosity=2, exit=False)
    result = program.result
    if result.testsRun and len(result.skipped) == result.testsRun:
        print('SKIPPED ALL')
    raise SystemExit(not result.wasSuccessful())
