# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of the example staircase: parts that pass, fail and are undecided."""
import json
import os
import subprocess

import command_line as cl

STAIRCASE = os.path.dirname(cl.NOMINAL)
ACTUAL = os.path.join(STAIRCASE, 'actual.csg')
TOLERANCES = os.path.join(STAIRCASE, 'tolerances.json')


class PageTest(cl.CommandLineTest):
    def simulate(self, name, model=cl.NOMINAL, points=8000, sigma_mm=0.02):
        done = self.run_command('simulate', '--model', model, '--out', name, '--points', points, '--sigma', sigma_mm, '--seed', 7, '--quiet')
        self.assertEqual(done.returncode, 0, done.stderr)

    def report(self, scan, verdict, model=cl.NOMINAL, tolerances=TOLERANCES, out='report'):
        """report.json and the page's text."""
        # Names in what it prints may be no text: as bytes.
        done = subprocess.run([os.path.join(cl.BIN, 'tetragauge'), 'inspect', scan, '--model', model, '--tolerances', tolerances, '--out', out,
                               '--quiet'], cwd=self.folder, capture_output=True, timeout=300, check=False)
        self.assertIn(done.returncode, (0, 1, 5), done.stderr)
        json_report = json.loads(self.read(f'{out}/report.json'))
        self.assertEqual(json_report['verdict'], verdict)
        return json_report, self.read(f'{out}/report.html').decode()
