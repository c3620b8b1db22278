# SPDX-License-Identifier: GPL-3.0-or-later
"""examples/: the commands of their READMEs do what these say."""
import json
import math
import os

import command_line as cl

EXAMPLES = os.path.join(cl.ROOT, 'examples')


class Examples(cl.CommandLineTest):
    def measure(self, folder, suffix):
        at = lambda name: os.path.join(EXAMPLES, folder, name)
        done = self.run_command('measure', '--emulated', at('actual' + suffix), '--model', at('nominal' + suffix),
                                '--tolerances', at('tolerances.json'), '--out', 'report', timeout=170)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        return json.loads(self.read('report/report.json'))

    def failed_faces(self, report, model):
        failed = [f for f in report['faces'] if f['verdict'] == 'fail']
        others = {f['verdict'] for f in report['faces']} - {'fail'}
        self.assertEqual(others, {'pass', 'skipped'})
        faces = self.run_json('model', os.path.join(EXAMPLES, model))['faces']
        return [(f, next(m for m in faces if m['id'] == f['id'])) for f in failed]

    def test_bracket(self):
        report = self.measure('bracket', '.step')
        # Oracle: drawn 12 mm thick, made 12.35. Strips of its bores are no extra faces.
        [(measured, drawn)] = self.failed_faces(report, 'bracket/nominal.step')
        self.assertEqual((drawn['type'], drawn['normal']), ('plane', [1, 0, 0]))
        self.assertAlmostEqual(drawn['d_mm'], 12, 6)
        self.assertLess(abs(measured['deviations']['offset_mm'] - 0.35), measured['U_mm']['offset'])
        self.assertEqual(report['extra_faces'], [])

    def test_channel(self):
        report = self.measure('channel', '.csg')
        # Oracle: one inner wall leans by 0.4 degrees; which of the two of the drawing, no one can say.
        [(measured, drawn)] = self.failed_faces(report, 'channel/nominal.csg')
        self.assertIn((drawn['normal'][1], round(drawn['d_mm'], 6)), [(1, 12), (-1, -44)])
        self.assertLess(abs(measured['deviations']['tilt_mrad'] - math.radians(0.4) * 1000), measured['U_mm']['tilt_mrad'])
        self.assertEqual(len(report['equivalents']), 1)

    def test_plan_of_the_staircase(self):
        planned = self.run_command('plan', '--model', cl.NOMINAL, '--place=90,0,0,0,0,0', '--out', 'plan.json')
        self.assertEqual(planned.returncode, 0, planned.stderr)
        self.assertEqual(self.read('plan.json'), open(os.path.join(EXAMPLES, 'staircase', 'plan.json'), 'rb').read())


if __name__ == '__main__':
    cl.main()
