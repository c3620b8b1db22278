# SPDX-License-Identifier: GPL-3.0-or-later
"""STEP files by others: units, and a part of 37 planes with all its symmetric poses."""
import os

import command_line as cl

STEP = os.path.join(cl.SHARED, 'data', 'step')


@cl.needs_shared('data/step')
class RealModels(cl.CommandLineTest):
    def test_units(self):
        # Extents from the table of the data's own description.
        for file, size_mm in [('occt_import_js/cube-in.step', (1000, 1000, 1000)), ('occt_import_js/cube-m.step', (1000, 1000, 1000)),
                              ('occt_import_js/cube-mm.step', (1000, 1000, 1000)), ('occwl/118539_1dff9cf9_6.stp', (20, 5, 15.03)),
                              ('nist/nist_ctc_01_asme1_ap242-e1.stp', (800, 450, 150)), ('occwl/Block_hole.step', (50, 50, 30))]:
            with self.subTest(file):
                model = self.run_json('model', os.path.join(STEP, file))
                size = [high - low for low, high in zip(model['box_min_mm'], model['box_max_mm'])]
                for got, wanted in zip(sorted(size), sorted(size_mm)):
                    self.assertAlmostEqual(got, wanted, delta=max(0.01, 1e-3 * wanted))

    def test_suspicious_unit_is_a_warning(self):
        model = self.run_json('model', os.path.join(STEP, 'occt_import_js/as1_pe_203.stp'))
        self.assertTrue(any('unit' in warning for warning in model['warnings']), model['warnings'])

    def test_polygon_35(self):
        part = os.path.join(STEP, 'occwl/polygon_35_side.step')
        done = self.run_command('simulate', '--model', part, '--out', 'scan.ply', '--points', 40000, '--sigma', 0.02,
                                '--pose=20,-35,110,5,-8,12')
        self.assertEqual(done.returncode, 0, done.stderr)
        report = self.run_json('inspect', 'scan.ply', '--model', part, '--out', 'report')
        self.assertEqual([f['id'] for f in report['faces'] if f['measured']], list(range(1, 38)))
        self.assertEqual(report['extra_faces'], [])
        # A regular prism of 35 sides turns into itself 35 x 2 ways: the chosen pose and 69 others.
        self.assertEqual(len(report['equivalents']), 69)


if __name__ == '__main__':
    cl.main()
