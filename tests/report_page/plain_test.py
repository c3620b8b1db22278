# SPDX-License-Identifier: GPL-3.0-or-later
"""report.html without its script: verdict and numbers stand in plain HTML and are those of report.json; names from files are text and
never markup; the page is small, and the same for the same run."""
import base64
import html.parser
import json
import math
import os
import shutil
import statistics
import struct
import unittest

import command_line as cl
from pages import ACTUAL, TOLERANCES, PageTest

# May stand open, by the HTML standard.
VOID = {'meta', 'br', 'hr', 'img', 'input', 'link', 'rect', 'path', 'circle'}


class Document(html.parser.HTMLParser):
    """Elements with their attributes and text, in their order; checks that tags close as they opened."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.open, self.faults = [], [], []
        self.feed(text)
        self.close()
        self.faults += [f'<{e["tag"]}> stays open' for e in self.open]

    def handle_starttag(self, tag, attrs):
        element = {'tag': tag, 'attributes': dict(attrs), 'text': '', 'path': [e['tag'] for e in self.open]}
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attrs):
        self.elements.append({'tag': tag, 'attributes': dict(attrs), 'text': '', 'path': []})

    def handle_endtag(self, tag):
        if not self.open or self.open[-1]['tag'] != tag:
            self.faults.append(f'</{tag}> closes {self.open[-1]["tag"] if self.open else "nothing"}')
            return
        self.open.pop()

    def handle_data(self, data):
        for element in self.open:
            element['text'] += data

    def all(self, tag):
        return [e for e in self.elements if e['tag'] == tag]

    def rows(self):
        """Of the table of faces: face id to the texts of its cells."""
        rows, cells = {}, None
        for element in self.elements:
            if element['tag'] == 'tr':
                cells = rows.setdefault(int(element['attributes']['data-face']), []) if 'data-face' in element['attributes'] else None
            elif element['tag'] in ('td', 'th') and cells is not None:
                cells.append(element)
        return {face: [' '.join(c['text'].split()) for c in cells] for face, cells in rows.items()}


def number(text):
    return float(text.replace('−', '-').removesuffix(' %'))


class Plain(PageTest):
    def test_table_without_a_script(self):
        self.simulate('scan.ply', ACTUAL)
        report, text = self.report('scan.ply', 'fail')
        page = Document(text)
        self.assertEqual(page.faults, [])
        first_line = self.read('report/report.txt').decode().splitlines()[0]
        self.assertEqual([e['text'] for e in page.all('h1')], [first_line.replace('+-', '±')])
        rows = page.rows()
        self.assertEqual(sorted(rows), [face['id'] for face in report['faces']])
        self.assertEqual(next(iter(rows)), next(f['id'] for f in report['faces'] if f['verdict'] == 'fail'))  # worst first
        words = {'pass': '✓ Pass', 'fail': '✗ Fail', 'skipped': '– Skipped'}
        for face in report['faces']:
            cells = rows[face['id']]
            self.assertEqual(cells[1], words[face['verdict']])
            self.assertEqual(number(cells[-1]), face['points_used'])
            self.assertAlmostEqual(number(cells[-2]), 100 * face['coverage'], delta=0.5)
            self.assertAlmostEqual(number(cells[-5]), face['deviations']['offset_mm'], delta=5.1e-4)
            if face['verdict'] != 'skipped':
                for cell, key in ((4, 'deviation_mm'), (5, 'U_mm'), (6, 'limit_mm')):
                    self.assertAlmostEqual(number(cells[cell]), face['decided_by'][key], delta=5.1e-4)
        for key in ('scan', 'model', 'tolerances'):
            self.assertIn(report['input'][key]['sha256'], text)
        self.assertIn('JavaScript', page.all('noscript')[0]['text'])

    def test_what_is_drawn(self):
        """Oracle: the riser of actual.csg stands 0.4 mm out, all else is right. So its colours say 0.4 mm all over, those of the other faces
        nothing, and beams that should have met it end 0.4 mm early, the more the flatter they came (to 80 degrees)."""
        riser = 14
        self.simulate('scan.ply', ACTUAL, points=20000)
        _, text = self.report('scan.ply', 'fail')
        data = json.loads(next(e['text'] for e in Document(text).all('script') if e['attributes'].get('id') == 'data'))

        def lengths(packed):
            steps = [s[0] for s in struct.iter_unpack('<h', base64.b64decode(packed))]
            return [None if abs(s) >= 32767 else s * data['unit_mm'] for s in steps]

        def ids(packed):
            return [s[0] for s in struct.iter_unpack('<H', base64.b64decode(packed))]

        for face, deviation in zip(ids(data['mesh']['faces']), lengths(data['mesh']['deviations'])):
            if deviation is not None:
                self.assertAlmostEqual(deviation, 0.4 if face == riser else 0, delta=0.05)
        seen = 0
        for image in data['images']:
            self.assertEqual(len(ids(image['faces'])), image['width'] * image['height'])
            of_face = {}
            for face, beyond in zip(ids(image['faces']), lengths(image['beyond'])):
                if face and beyond is not None:
                    of_face.setdefault(face, []).append(beyond)
            for face, values in of_face.items():
                if len(values) < 20:
                    continue
                middle = statistics.median(values)
                if face == riser:
                    seen += 1
                    self.assertTrue(-0.4 / math.cos(math.radians(80)) < middle < -0.37, middle)
                else:
                    self.assertLess(abs(middle), 0.03, (image['views'], face))
        self.assertGreaterEqual(seen, 2)

    def test_asks_nothing_of_a_network(self):
        self.simulate('scan.ply')
        _, text = self.report('scan.ply', 'pass')
        page = Document(text)
        policy = [e['attributes']['content'] for e in page.all('meta') if e['attributes'].get('http-equiv') == 'Content-Security-Policy']
        self.assertTrue(policy and policy[0].startswith("default-src 'none'"), policy)
        for element in page.elements:
            for name, value in element['attributes'].items():
                if name in ('src', 'href', 'action', 'data', 'poster'):
                    self.assertTrue(value.startswith('#'), (element['tag'], name, value))

    def test_same_run_same_page(self):
        self.simulate('scan.ply', ACTUAL)
        pages = [self.report('scan.ply', 'fail', out=f'out{k}')[1] for k in range(2)]
        self.assertEqual(pages[0], pages[1])
        self.assertNotIn('timing_s', pages[0])

    def test_names_are_text(self):
        """File names and a part's serial that try to be markup, and bytes that are no text."""
        evil = '"\'><img src=x onerror=hit()>&amp;'
        folder = 'a<'
        os.makedirs(self.path(f'{folder}/script><script>hit()<'))
        model = f'{folder}/script><script>hit()<' + '/script>-->.csg'
        shutil.copy(cl.NOMINAL, self.path(model))
        self.simulate('scan.ply', points=4000)
        head, body = self.read('scan.ply').split(b'end_header\n', 1)
        scan = os.fsencode(self.path(evil.replace('/', '') + 'x')) + b'\xff.ply'
        with open(scan, 'wb') as file:
            file.write(head + b'comment part_serial ' + evil.encode() + b' </script>\n' + b'end_header\n' + body)
        report, text = self.report(os.fsdecode(scan), 'pass', model=model)
        self.assertTrue(report['input']['scan']['name'].endswith('x\ufffd.ply'))
        page = Document(text)
        self.assertEqual(page.faults, [])
        self.assertEqual(len(page.all('script')), 2)
        self.assertEqual(page.all('img'), [])
        self.assertIn(evil + ' </script>', page.all('header')[0]['text'])
        self.assertIn(model, ' '.join(e['text'] for e in page.all('dd')))
        data = json.loads(next(e['text'] for e in page.all('script') if e['attributes'].get('id') == 'data'))
        self.assertEqual(data['report']['input'], report['input'])

    def test_size(self):
        """A page of 100,000 points stays under 3 MB: fewer are drawn, and it says how many."""
        self.simulate('scan.ply', ACTUAL, points=100000)
        report, text = self.report('scan.ply', 'fail')
        self.assertGreater(report['input']['points'], 90000)
        self.assertLess(len(text.encode()), 3e6)
        data = json.loads(next(e['text'] for e in Document(text).all('script') if e['attributes'].get('id') == 'data'))
        points = data['points']
        self.assertEqual(points['all'], report['input']['points'])
        self.assertLess(points['shown'], 35000)
        # What is drawn is the scan's: each is within rounding of a measured point, and they come from all over it.
        self.assertEqual(len(base64.b64decode(points['places'])), 6 * points['shown'])
        count = struct.unpack(f'<{points["shown"]}H', base64.b64decode(points['faces']))
        for face in report['faces']:
            expected = face['points_used'] * points['shown'] / points['all']
            self.assertLess(abs(count.count(face['id']) - expected), 5 * expected**0.5 + 1)
        # The views' pictures use every point.
        self.assertEqual(sum(image['rays'] for image in data['images']), points['all'])


if __name__ == '__main__':
    cl.main()
