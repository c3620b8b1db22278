# SPDX-License-Identifier: GPL-3.0-or-later
"""report.html in headless Chromium: it loads without a complaint and without a network; picture, table and panel show the same face
whichever was used to choose it, by mouse or keyboard; colours and places are those of the part."""
import json
import unittest

import command_line as cl
from chromium import PROGRAM, Browser, Page
from pages import ACTUAL, PageTest

RISER = 14  # the one that is 0.4 mm out


@unittest.skipUnless(PROGRAM, 'needs Chromium (Debian: apt-get install chromium)')
class InBrowser(PageTest):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)

    def open(self, out='report', **options):
        page = Page(self.browser, f'file://{self.path(out)}/report.html', **options)
        self.addCleanup(page.call, 'Page.close')
        return page

    def failing(self):
        self.simulate('scan.ply', ACTUAL)
        return self.report('scan.ply', 'fail')[0]

    def check_chosen(self, page, face):
        """Picture, table and panel agree; 0: none."""
        self.assertEqual(page.evaluate('Number(document.querySelector(".stage").dataset.chosen)'), face)
        rows = page.evaluate('[...document.querySelectorAll("tr[aria-current]")].map((row) => Number(row.dataset.face))')
        self.assertEqual(rows, [face] if face else [])
        if face:
            self.assertTrue(page.evaluate('document.querySelector(".panel h2").textContent').startswith(f'Face {face} '))

    def test_loads_quietly(self):
        """Pass, fail and undecided, in light and dark, wide and narrow, without a complaint or a request."""
        self.simulate('good.ply')
        self.simulate('coarse.ply', points=1500, sigma_mm=0.2)
        reports = {'report': self.failing(), 'good': self.report('good.ply', 'pass', out='good')[0],
                   'coarse': self.report('coarse.ply', 'undecided', out='coarse')[0]}
        for out, width in (('report', 1400), ('good', 420), ('coarse', 1400)):
            page = self.open(out, width=width)
            page.call('Emulation.setEmulatedMedia', {'features': [{'name': 'prefers-color-scheme', 'value': 'dark'}]})
            page.drawn()
            for mode in ('verdict', 'coverage', 'points', 'deviation'):
                page.evaluate(f'document.querySelector("input[value={mode}]").click()')
                page.drawn()
                self.assertEqual(page.evaluate('document.querySelector(".stage").dataset.mode'), mode)
                self.assertTrue(page.evaluate('document.querySelector(".legend").textContent'))
            self.assertEqual(page.evaluate('document.querySelectorAll(".view canvas").length'), 8)
            self.assertEqual(page.evaluate('document.querySelectorAll(".sphere .measured").length'), len(reports[out]['pairs']))
            # Nothing but the tables is wider than the window.
            self.assertLessEqual(page.evaluate('document.documentElement.scrollWidth'), width)
            self.assertEqual(page.complaints(), [])
            self.assertEqual(page.requests(), [f'file://{self.path(out)}/report.html'])

    def test_a_click_in_the_picture_chooses_the_face_there(self):
        """Oracle: the staircase seen from above. Its box of 80 x 60 mm is fitted into 0.88 of the picture, and the step at x has the
        height that the drawing says."""
        self.failing()
        faces = self.run_json('model', cl.NOMINAL)['faces']
        page = self.open()
        page.evaluate('[...document.querySelectorAll(".directions button")].find((b) => b.textContent === "Top").click()')
        page.drawn()
        left, top, width, height = page.box('.stage canvas')
        scale = 0.88 * min(width / 80, height / 60)
        for x_mm, z_mm in ((10, 60), (30, 50), (52, 40), (70, 20)):
            step = next(f['id'] for f in faces if f['normal'] == [0, 0, 1] and abs(f['d_mm'] - z_mm) < 1e-6)
            page.click(left + width / 2 + (x_mm - 40) * scale, top + height / 2)
            self.check_chosen(page, step)
        page.click(left + 5, top + 5)
        self.check_chosen(page, 0)

    def test_a_row_chooses_its_face_and_the_picture_turns_to_it(self):
        report = self.failing()
        page = self.open()
        self.check_chosen(page, RISER)  # the worst, from the start
        for face in report['faces']:
            page.evaluate(f'document.querySelector("tr[data-face=\'{face["id"]}\']").click()')
            page.drawn()
            self.check_chosen(page, face['id'])
            # The label of the chosen face stands on it: a click right there chooses the same face in the picture.
            left, top, _, _ = page.box('.stage')
            x, y = page.evaluate('(() => { const s = document.querySelector(".label.chosen").style; return [parseFloat(s.left), parseFloat(s.top)]; })()')
            page.evaluate('document.querySelector("tr[data-face]").dispatchEvent(new KeyboardEvent("keydown", {key: "Escape", bubbles: true}))')
            self.check_chosen(page, 0)
            page.click(left + x, top + y)
            self.check_chosen(page, face['id'])
            self.assertEqual(page.evaluate('document.querySelectorAll(".histogram .column").length') > 0, face['points_used'] > 0)

    def test_colours_are_those_of_the_deviation(self):
        """The riser has 0.4 mm too much, four limits: dark orange. A tread is right: near white. In a dark page too."""
        self.failing()
        for scheme in ('light', 'dark'):
            page = self.open()
            page.call('Emulation.setEmulatedMedia', {'features': [{'name': 'prefers-color-scheme', 'value': scheme}]})
            page.evaluate('[...document.querySelectorAll(".directions button")].find((b) => b.textContent === "Right").click()')
            page.evaluate('document.querySelector("tr[data-face]").dispatchEvent(new KeyboardEvent("keydown", {key: "Escape", bubbles: true}))')
            page.drawn()
            left, top, width, height = page.box('.stage canvas')
            # Seen along -x: y runs to the right, z up; the risers end at z = 20, 40, 50 and 60 mm, this one goes from 20 to 40.
            scale = 0.88 * min(width / 60, height / 60)
            at = lambda y_mm, z_mm: page.pixel(left + width / 2 + (y_mm - 30) * scale, top + height / 2 - (z_mm - 30) * scale)
            red, green, blue = at(12, 33)
            self.assertTrue(red > green + 40 > blue + 40, (red, green, blue))
            other = at(12, 10)
            self.assertLess(max(other) - min(other), 25, other)
            self.assertGreater(min(other), 150)

    def test_keyboard(self):
        report = self.failing()
        page = self.open()
        order = page.evaluate('[...document.querySelectorAll("tr[data-face]")].map((row) => Number(row.dataset.face))')
        self.assertEqual(sorted(order), [face['id'] for face in report['faces']])
        # One row can be reached by Tab; the arrows go on from there.
        self.assertEqual(page.evaluate('document.querySelectorAll("tr[data-face][tabindex=\'0\']").length'), 1)
        page.evaluate('document.querySelector("tr[data-face][tabindex=\'0\']").focus()')
        for key, face in (('ArrowDown', order[1]), ('ArrowDown', order[2]), ('ArrowUp', order[1]), ('End', order[-1]), ('Home', order[0])):
            page.press(key)
            self.check_chosen(page, face)
            self.assertEqual(page.evaluate('Number(document.activeElement.dataset.face)'), face)
        page.press('Escape')
        self.check_chosen(page, 0)
        # In the picture the arrows turn the part.
        page.evaluate('document.querySelector(".stage canvas").focus()')
        axes = 'document.querySelector(".axes path").getAttribute("d")'
        before = page.evaluate(axes)
        page.press('ArrowLeft')
        self.assertNotEqual(page.evaluate(axes), before)
        page.press('ArrowRight')
        # Back where it was, but for rounding.
        self.assertEqual([round(float(n)) for n in page.evaluate(axes).replace('M0 0L', '').split()], [round(float(n)) for n in before.replace('M0 0L', '').split()])

    def test_names_are_text(self):
        """A part's serial that tries to be a script stays text."""
        self.simulate('scan.ply', points=4000)
        head, body = self.read('scan.ply').split(b'end_header\n', 1)
        serial = '</script><script>document.title = "hit"</script><img src=x onerror="document.title = \'hit\'">'
        self.write('named.ply', head + f'comment part_serial {serial}\n'.encode() + b'end_header\n' + body)
        self.report('named.ply', 'pass')
        page = self.open()
        self.assertEqual(page.evaluate('document.title'), 'Pass: nominal.csg')
        self.assertIn(serial, page.evaluate('document.querySelector("header").textContent'))
        self.assertEqual(page.complaints(), [])
        self.assertEqual(len(page.requests()), 1)

    def test_without_a_script(self):
        self.failing()
        page = self.open(scripts=False)
        self.assertIsNone(page.evaluate('document.documentElement.dataset.ready ?? null'))
        self.assertTrue(page.evaluate('document.querySelector("h1").checkVisibility()'))
        self.assertEqual(page.evaluate('[...document.querySelectorAll("tr[data-face]")].filter((row) => row.checkVisibility()).length'), 15)

    def test_on_paper(self):
        """The picture is in what is printed: many of its pixels are the part's."""
        self.failing()
        page = self.open()
        self.assertTrue(page.pdf().startswith(b'%PDF'))
        drawn = json.loads(page.evaluate('''(() => {
            const paper = document.querySelector('.stage .paper');
            const data = paper.getContext('2d').getImageData(0, 0, paper.width, paper.height).data;
            let filled = 0;
            for (let k = 3; k < data.length; k += 4) filled += data[k] > 0;
            return JSON.stringify(filled / (paper.width * paper.height));
        })()'''))
        self.assertGreater(drawn, 0.15)
        self.assertEqual(page.complaints(), [])


if __name__ == '__main__':
    cl.main()
