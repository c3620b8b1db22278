#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Each structure check finds a fault put before it, and none where there is none."""
import os
import tempfile
import unittest

import check_structure


class Checks(unittest.TestCase):
    def tree(self, sources):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for path, text in sources.items():
            os.makedirs(os.path.join(folder.name, os.path.dirname(path)), exist_ok=True)
            with open(os.path.join(folder.name, path), 'w', encoding='utf-8') as file:
                file.write(text)
        return folder.name

    def test_edges(self):
        good = self.tree({'host/inspect/a.cpp': '#include "host/geometry/vec.hpp"\n#include <CLI11>\n',
                          'host/link/b.cpp': '#include "firmware/optics/galvo.hpp"\n',
                          'firmware/scan/c.hpp': '#include "firmware/motion/axis.hpp"\n'})
        self.assertEqual(list(check_structure.check_includes(good)), [])
        for path, line in [('host/geometry/a.cpp', '#include "host/match/match.hpp"'),
                           ('host/link/a.cpp', '#include "firmware/scan/scan.hpp"'),
                           ('sim/a.cpp', '#include "firmware/optics/galvo.hpp"'),
                           ('firmware/a.hpp', '#include "host/base/result.hpp"'),
                           ('host/match/a.cpp', '#include <CGAL/Delaunay_triangulation_3.h>'),
                           ('host/match/a.cpp', '#include <embree3/rtcore.h>'),
                           ('host/cli/a.cpp', '#include <gp_Pnt.hxx>'),
                           ('host/match/a.cpp', '#include "match.hpp"')]:
            faults = list(check_structure.check_includes(self.tree({path: line + '\n'})))
            self.assertEqual(len(faults), 1, (path, line, faults))

    def test_no_edge_goes_back(self):
        for module in check_structure.EDGES:
            for other in check_structure.reachable(module) - {module}:
                if {module, other} != {'firmware', 'firmware/optics'}:
                    self.assertNotIn(module, check_structure.reachable(other), (module, other))

    def test_spdx(self):
        self.assertEqual(len(list(check_structure.check_spdx(self.tree({'sim/a.cpp': 'int a;\n'})))), 1)
        wrong = self.tree({'sim/a.cpp': '// SPDX-License-Identifier: Apache-2.0\n'})
        self.assertEqual(len(list(check_structure.check_spdx(wrong))), 1)

    def test_formatting(self):
        tree = self.tree({'.clang-format': 'BasedOnStyle: Google\n', 'a.cpp': 'int   a ;\n', 'b.cpp': 'int b;\n'})
        faults = list(check_structure.check_formatting(tree, 'clang-format-14'))
        self.assertEqual([f.split(':')[0] for f in faults], ['a.cpp'])


if __name__ == '__main__':
    unittest.main()
