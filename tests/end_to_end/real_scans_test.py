# SPDX-License-Identifier: GPL-3.0-or-later
"""Laser-line scans of a real steel plate on a table: both are found as planes, as far apart as the plate is thick."""
import glob
import math
import os
import subprocess
import sys

import command_line as cl

PLATE = 'data/scans/saxion_plates_laserline/plate01'


@cl.needs_shared(PLATE)
class RealScans(cl.CommandLineTest):
    def test_plate_stands_off_the_table(self):
        gaps = []
        scans = sorted(glob.glob(os.path.join(cl.SHARED, PLATE, '*.png')))
        self.assertEqual(len(scans), 6)
        for png in scans:
            with self.subTest(os.path.basename(png)):
                subprocess.run([sys.executable, os.path.join(cl.SHARED, 'tools', 'saxion_to_ply.py'), png, self.path('plate.ply')],
                               check=True, capture_output=True)
                faces = self.run_json('faces', 'plate.ply')['faces']
                # The table is the largest plane; the plate's top the largest one clearly above it that looks the same way.
                table = max(faces, key=lambda f: f['area_mm2'])
                n, d = table['normal'], table['d_mm']
                self.assertGreater(n[2], 0.99)
                height = lambda f: sum(a * b for a, b in zip(n, f['point_mm'])) - d
                above = [f for f in faces if height(f) > 5 and sum(a * b for a, b in zip(n, f['normal'])) > 0.99]
                self.assertTrue(above, 'no plane above the table')
                top = max(above, key=lambda f: f['area_mm2'])
                gaps.append(height(top))
                self.assertGreater(height(top), 10.0)
                self.assertLess(height(top), 10.4)
                cosine = min(1.0, sum(a * b for a, b in zip(n, top['normal'])))
                self.assertLess(math.degrees(math.acos(cosine)), 0.25)
        print('plate top above the table, mm:', ' '.join(f'{g:.3f}' for g in gaps))
        self.assertLess(max(gaps) - min(gaps), 0.25)


if __name__ == '__main__':
    cl.main()
