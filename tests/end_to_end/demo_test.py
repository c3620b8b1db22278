# SPDX-License-Identifier: GPL-3.0-or-later
"""script/demo: the emulated machine measures the staircase; the riser that is 0.4 mm out and the broken edge are named, the good
part passes."""
import json
import math
import os
import subprocess

import command_line as cl


class Demo(cl.CommandLineTest):
    def test_verdicts(self):
        done = subprocess.run([os.path.join(cl.ROOT, 'script', 'demo'), '--built', cl.BIN], capture_output=True, text=True,
                              env={**os.environ, 'TETRAGAUGE_DEMO_OUT': self.folder}, timeout=170, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

        good = json.loads(self.read('good/report.json'))
        self.assertEqual(good['verdict'], 'pass')
        verdicts = {f['verdict'] for f in good['faces']}
        self.assertEqual(verdicts, {'pass', 'skipped'})
        self.assertEqual([f['verdict'] for f in good['faces']].count('skipped'), 1)

        bad = json.loads(self.read('bad/report.json'))
        self.assertEqual(bad['verdict'], 'fail')
        failed = [f for f in bad['faces'] if f['verdict'] == 'fail']
        # Oracle: the part was made with the riser x = 60 mm standing at 60.4 mm, and without the edge (80, 20), of which 4 mm are gone.
        model = self.run_json('model', cl.NOMINAL)['faces']
        face_at = lambda normal, d: next(f['id'] for f in model if f['normal'] == normal and abs(f['d_mm'] - d) < 1e-6)
        self.assertEqual([f['id'] for f in failed], [face_at([1, 0, 0], 60)])
        offset, uncertainty = failed[0]['deviations']['offset_mm'], failed[0]['U_mm']['offset']
        self.assertLess(abs(offset - 0.4), uncertainty)
        self.assertLess(uncertainty, 0.05)
        beside_edge = {face_at([1, 0, 0], 80), face_at([0, 0, 1], 20)}
        missing = [f for f in bad['material_faults'] if f['kind'] == 'missing']
        self.assertTrue(missing)
        for fault in missing:
            self.assertIn(fault['face'], beside_edge)
            self.assertLess(math.dist((fault['point_mm'][0], fault['point_mm'][2]), (80, 20)), 4.5)
        self.assertIn('face 14', done.stdout)

    def test_runs_repeat(self):
        arguments = ['scan', '--emulated', cl.NOMINAL, '--place=90,0,0,0,0,0', '--seed', 5]
        for name in ('first.ply', 'second.ply'):
            done = self.run_command(*arguments, '--out', name)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.read('first.ply'), self.read('second.ply'))
        reports = []
        for threads in (1, 2):
            report = self.run_json('inspect', 'first.ply', '--model', cl.NOMINAL, '--out', 'report', '--threads', threads)
            report.pop('timing_s')
            reports.append(report)
        self.assertEqual(*reports)


if __name__ == '__main__':
    cl.main()
