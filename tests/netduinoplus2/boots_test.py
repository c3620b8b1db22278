#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""usage: boots_test.py IMAGE.elf TETRAGAUGE_HELLO

The image for the STM32-H405, byte for byte what is flashed, on QEMU's STM32F405 (machine netduinoplus2): boots, answers the
host's own link library (Hello, Status, SelfTest), and names what this emulated chip lacks. That one has no RCC, GPIO, DAC,
DMA, RNG or flash interface, its converters never end a conversion, its timers have no compare interrupt, and TIM2 runs at
1 GHz (QEMU 7.2, hw/arm/stm32f405_soc.c) beside a SysTick at the right 168 MHz.
"""
import json
import os
import re
import shutil
import sys
import time
import unittest

IMAGE, HELLO = sys.argv[1:3]
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
sys.path.insert(0, os.path.join(ROOT, 'tests', 'mps2_an386'))
from serial_qemu import PATIENCE_S, SerialQemu  # noqa: E402

TIM2_OFF_PPM = (1000 / 84 - 1) * 1e6  # 1 GHz instead of 84 MHz


def clock_off_ppm(said):
    return next(item['value'] for item in said['self_test'] if item['check'] == 'clock')


class Machine(SerialQemu):
    def __init__(self):
        # Time is counted by instructions: what the timers show depends little on how busy this computer is.
        super().__init__('netduinoplus2', IMAGE, '-icount', 'shift=3', '-d', 'guest_errors')

    def enter_bootloader(self):
        done = self.run_host(HELLO, '--port', self.port, '--patience', str(PATIENCE_S), '--bootloader')
        assert done.returncode == 0, done.stderr

    def hello(self):
        done = self.run_host(HELLO, '--port', self.port, '--patience', str(PATIENCE_S), '--json')
        assert done.returncode in (0, 1), done.stderr
        return done.returncode, json.loads(done.stdout)


class BootsOnNetduinoplus2(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with Machine() as machine:
            cls.code, cls.said = machine.hello()
            cls.clock_off_ppm = [clock_off_ppm(cls.said)]
            # A QEMU that has to wait for its turn delivers SysTick's interrupts late, never early: asked until it once had its
            # turn for as long as a comparison takes, 32 ms.
            ends = time.monotonic() + PATIENCE_S
            while min(cls.clock_off_ppm) > 1.01 * TIM2_OFF_PPM and time.monotonic() < ends:
                cls.clock_off_ppm.append(clock_off_ppm(machine.hello()[1]))
            cls.accesses = machine.said()
        print(json.dumps(cls.said, indent=1))
        cls.test = {item['check']: item for item in cls.said['self_test']}

    def test_hello_carries_the_versions_of_this_tree(self):
        def number(path, pattern):
            return re.search(pattern, open(os.path.join(ROOT, path), encoding='utf-8').read())[1]
        self.assertEqual(self.said['board'], 'stm32_h405')
        self.assertEqual(self.said['firmware_version'], number('firmware/version.hpp', r'kFirmwareVersion = "([^"]+)"'))
        self.assertEqual(self.said['protocol_version'], int(number('protocol/frame.hpp', r'kProtocolVersion = (\d+)')))

    def test_status_is_that_of_a_machine_with_nothing_plugged_in(self):
        # No input is high: the interlock's loop is open, both end switches are.
        self.assertEqual(self.said['state'], 'ESTOP')
        self.assertEqual(self.said['inputs'], 32 | 64)

    def test_self_test_names_what_this_chip_lacks(self):
        self.assertEqual(self.code, 1)
        failed = {check for check, item in self.test.items() if item['result'] == 'FAILED'}
        self.assertEqual(failed, {'interlock', 'mirrors', 'laser driver', 'converter', 'dark camera 1', 'dark camera 2',
                                  'noise camera 1', 'noise camera 2', 'step timers', 'clock', 'transport'})
        self.assertEqual(self.test['transport']['value'], 0)  # on interrupts: there is no DMA
        self.assertEqual({check for check in self.test} - failed, {'store'})

    def test_every_wait_that_ended_without_is_named(self):
        for name in ('RCC_CR.HSERDY', 'RCC_CR.PLLRDY', 'FLASH_ACR.LATENCY', 'DMA2 copies nothing', 'RNG_SR.DRDY'):
            self.assertEqual(sum(line.startswith(name) for line in self.said['log']), 1, name)
        # And nothing else but that there is no calibration.
        self.assertEqual(len(self.said['log']), 6, self.said['log'])

    def test_systick_and_tim2_are_timed_against_each_other(self):
        self.assertAlmostEqual(min(self.clock_off_ppm), TIM2_OFF_PPM, delta=0.01 * TIM2_OFF_PPM)

    def test_nothing_is_touched_that_no_stm32f405_has(self):
        self.assertNotIn('Invalid', self.accesses)

    def test_enter_bootloader_reaches_for_it_and_a_crash_is_told(self):
        # This chip has no bootloader: reading it is a hard fault, which the next start reports.
        with Machine() as machine:
            machine.enter_bootloader()
            _, said = machine.hello()
            self.assertRegex(machine.said(), r'Invalid read at addr 0x1FFF0000')
        self.assertIn('the firmware has crashed (hard fault) and started again', said['log'])
        self.assertEqual(said['boot_id'], self.said['boot_id'] + 1)


if __name__ == '__main__':
    if shutil.which('qemu-system-arm') is None:
        print('boots_on_netduinoplus2: skipped, qemu-system-arm is missing; run script/setup, which installs it')
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
