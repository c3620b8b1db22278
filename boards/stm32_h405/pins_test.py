#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""usage: pins_test.py ROOT    the pins of pins.hpp are those of the table in docs/machine.md, and none is used twice."""
import os
import re
import sys


def main():
    root = sys.argv[1]
    code = open(os.path.join(root, 'boards/stm32_h405/pins.hpp'), encoding='utf-8').read()
    doc = open(os.path.join(root, 'docs/machine.md'), encoding='utf-8').read()
    pins = {name: f'P{port}{number}' for name, port, number in
            re.findall(r'using (\w+) = Pin<PortName::k([A-D]), (\d+)>;', code)}
    rows = dict(re.findall(r'^\| (\w+) \| (P[A-D]\d+) \|', doc, re.M))
    faults = [f'{name} is {pins.get(name)} in pins.hpp and {rows.get(name)} in docs/machine.md'
              for name in sorted(pins.keys() | rows.keys()) if pins.get(name) != rows.get(name)]
    used = list(pins.values())
    faults += [f'{pin} is used twice' for pin in sorted(set(used)) if used.count(pin) > 1]
    if len(pins) < 20:
        faults.append('pins.hpp does not read as expected')
    print('\n'.join(faults) or f'{len(pins)} pins agree')
    sys.exit(1 if faults else 0)


main()
