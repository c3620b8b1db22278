#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: make_seeds.py GOLDEN_FRAMES_HPP OUT_DIR

The fuzzers' first inputs: frames/ has each golden frame as a line (mode 0) and its payload for the decoder (mode 1),
controller/ has the requests among them as scripts: home, load, scan and so on with time between.
"""
import os
import re
import sys


def payload_of(wire):
    data, at = bytearray(), 0
    body = wire[:-1]
    while at < len(body):
        code = body[at]
        data += body[at + 1:at + code]
        at += code
        if code != 255 and at < len(body):
            data.append(0)
    return bytes(data[5:-4])


def main():
    text = open(sys.argv[1], encoding='utf-8').read()
    rows = re.findall(r'\{"(\w+)", \d+, \d+, (true|false),\s*"([0-9a-f]+)"\}', text)
    if not rows:
        sys.exit(f'make_seeds: {sys.argv[1]} holds no golden frames')
    for folder in ('frames', 'controller'):
        os.makedirs(os.path.join(sys.argv[2], folder), exist_ok=True)

    def write(name, data):
        with open(os.path.join(sys.argv[2], name), 'wb') as file:
            file.write(data)

    requests = {}
    for name, from_host, hex_digits in rows:
        wire = bytes.fromhex(hex_digits)
        write(f'frames/{name}_line', b'\0' + wire)
        write(f'frames/{name}_payload', b'\1' + payload_of(wire))
        if from_host == 'true':
            requests[name] = payload_of(wire)
    write('frames/all_on_one_line', b'\0' + b''.join(bytes.fromhex(r[2]) for r in rows))

    # fuzz_controller.cpp says what the bytes mean.
    def ask(name):
        return bytes([0, len(requests[name])]) + requests[name]

    def event(name):
        return bytes([1, len(requests[name])]) + requests[name]

    def wait(tenths_s):
        return bytes([2, tenths_s])

    start = ask('hello') + ask('home') + wait(200)
    for name in requests:
        write(f'controller/{name}', start + ask(name) + wait(5) + ask('get_status'))
    scan = start + ask('scan_load') + ask('scan_start') + event('points_credit') + wait(30)
    write('controller/scan', scan + event('points_resend') + ask('scan_pause') + ask('scan_resume') + wait(30))
    write('controller/interlock', scan + bytes([3, 1]) + wait(1) + bytes([3, 0]) + ask('clear_fault') + wait(1))
    write('controller/aim', start + ask('laser_set') + ask('move_galvo') + wait(6) + ask('scan_resume') + wait(1))


main()
