# SPDX-License-Identifier: GPL-3.0-or-later
"""Views of real parts by a depth camera, in waves of 1 to 2 mm: the pose against the one that the data's makers measured."""
import os
import sys

import command_line as cl

sys.path.insert(0, os.path.join(cl.ROOT, 'tests', 'bench'))
import inspect_realsense as realsense  # noqa: E402

PARTS = 'data/scans/cranfield_realsense'


@cl.needs_shared(PARTS)
class RealPoses(cl.CommandLineTest):
    def test_ten_of_eleven_are_matched(self):
        folder = os.path.join(cl.SHARED, PARTS)
        scans = realsense.scans_in(folder)
        self.assertEqual(len(scans), 11)
        matched = []
        for scan in scans:
            errors, report = realsense.inspected(os.path.join(cl.BIN, 'tetragauge'), folder, scan, realsense.SIGMA_MM)
            self.assertTrue(errors, f'{scan}: {report}')
            if realsense.is_good(errors[0]):  # the pose reported first, not one of its equivalents
                matched.append(scan)
        self.assertGreaterEqual(len(matched), 10, matched)


if __name__ == '__main__':
    cl.main()
