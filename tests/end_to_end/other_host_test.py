# SPDX-License-Identifier: GPL-3.0-or-later
"""A host written anew speaks to the emulator: Google's protobuf for Python, and CRC and COBS of its own. What the protocol
says is what the machine does; and a calibration outlives a reboot, and the program with --store."""
import os
import socket
import subprocess
import sys
import time

import command_line as cl


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def cobs(data):
    out, at = bytearray(), 0
    while True:
        end = at
        while end < len(data) and data[end] and end - at < 254:
            end += 1
        out += bytes([end - at + 1]) + data[at:end]
        full, at = end - at == 254, end
        if at == len(data):
            return bytes(out)
        at += not full


def uncobs(wire):
    out, at = bytearray(), 0
    while at < len(wire):
        code = wire[at]
        out += wire[at + 1:at + code]
        at += code
        if code != 255 and at < len(wire):
            out.append(0)
    return bytes(out)


class OtherHost:
    REQUEST, REPLY, EVENT = 1, 2, 3

    def __init__(self, messages, path):
        self.messages, self.logs, self.id, self.received = messages, [], int(time.time()) % 1000000, b''
        self.line = socket.socket(socket.AF_UNIX)
        self.line.settimeout(60)
        self.line.connect(path)

    def send(self, channel, number, message):
        body = bytes([channel]) + number.to_bytes(4, 'little') + message.SerializeToString()
        self.line.sendall(b'\0' + cobs(body + crc32c(body).to_bytes(4, 'little')) + b'\0')

    def frame(self):
        while b'\0' not in self.received:
            more = self.line.recv(4096)
            if not more:
                raise EOFError('the machine has closed the line')
            self.received += more
        wire, self.received = self.received.split(b'\0', 1)
        if not wire:
            return self.frame()
        data = uncobs(wire)
        assert crc32c(data[:-4]) == int.from_bytes(data[-4:], 'little')
        return data[0], int.from_bytes(data[1:5], 'little'), self.messages.MachineMessage.FromString(data[5:-4])

    def ask(self, **body):
        self.id += 1
        self.send(self.REQUEST, self.id, self.messages.HostMessage(**body))
        while True:
            channel, number, message = self.frame()
            kind = message.WhichOneof('body')
            if channel == self.REPLY and number == self.id:
                return kind, getattr(message, kind)
            if kind == 'heartbeat':
                ack = self.messages.HeartbeatAck(counter=message.heartbeat.counter)
                self.send(self.EVENT, 0, self.messages.HostMessage(heartbeat_ack=ack))
            elif kind == 'log':
                self.logs.append(message.log.text)


class SpokenByAnother(cl.CommandLineTest):
    def setUp(self):
        super().setUp()
        subprocess.run(['protoc', '--proto_path', cl.ROOT, '--python_out', self.folder, 'protocol/machine.proto'], check=True)
        sys.path.insert(0, self.folder)
        self.addCleanup(sys.path.remove, self.folder)
        from protocol import machine_pb2
        self.m = machine_pb2

    def machine(self):
        process = subprocess.Popen([os.path.join(cl.BIN, 'tetragauge-emulator'), '--part', cl.NOMINAL, '--listen', 'unix:line',
                                    '--store', 'store'], cwd=self.folder, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.addCleanup(process.stdout.close)
        self.assertEqual(process.stdout.readline().strip(), 'unix:line')
        host = OtherHost(self.m, self.path('line'))
        self.addCleanup(host.line.close)
        return process, host

    def calibration(self, host):
        parts = {}
        for number, name in enumerate(['galvo', 'camera_1', 'camera_2', 'stage', 'measure', 'volume'], 1):
            _, config = host.ask(get_config=self.m.GetConfig(part=number))
            parts[name] = getattr(config, config.WhichOneof('part'))
        calibration = self.m.Calibration(id='ball plate 7', u_cal_100nm=73, **parts)
        calibration.galvo.a_zero_urad = 12.5
        return calibration.SerializeToString()

    def test_calibration_outlives_reboot_and_program(self):
        m = self.m
        process, host = self.machine()
        _, first = host.ask(hello=m.Hello(protocol_version=1))
        self.assertEqual((first.calibration_id, m.ResetCause.Name(first.reset_cause)), ('', 'RESET_POWER'))
        record = self.calibration(host)
        crc = crc32c(record)
        for at in range(0, len(record), 256):
            chunk = m.CalibrationChunk(offset=at, total=len(record), crc=crc, data=record[at:at + 256])
            self.assertEqual(host.ask(calibration_write=chunk)[0], 'done')
        self.assertEqual(host.ask(calibration_commit=m.CalibrationCommit(total=len(record), crc=crc))[0], 'done')
        self.assertEqual(host.logs, ['no calibration in the store: nominal numbers are in use'])

        self.assertEqual(host.ask(reboot=m.Reboot())[0], 'done')
        _, second = host.ask(hello=m.Hello(protocol_version=1))
        self.assertNotEqual(second.boot_id, first.boot_id)
        self.assertEqual((second.calibration_id, second.u_cal_100nm), ('ball plate 7', 73))
        self.assertEqual(m.ResetCause.Name(second.reset_cause), 'RESET_SOFTWARE')
        self.assertNotEqual(second.config_crc, first.config_crc)

        self.assertEqual(host.ask(enter_bootloader=m.EnterBootloader())[0], 'done')
        self.assertEqual(process.wait(30), 0, 'gone until it is started again')
        _, host = self.machine()
        _, third = host.ask(hello=m.Hello(protocol_version=1))
        self.assertEqual((third.calibration_id, third.config_crc), ('ball plate 7', second.config_crc))
        read = b''
        while len(read) < len(record):
            read += host.ask(calibration_read=m.CalibrationRead(offset=len(read)))[1].data
        self.assertEqual(read, record)

    def test_self_test_passes_on_the_simulated_machine(self):
        m = self.m
        _, host = self.machine()
        host.ask(hello=m.Hello(protocol_version=1))
        kind, reply = host.ask(self_test=m.SelfTest())
        self.assertEqual(kind, 'self_test')
        self.assertEqual(sorted(item.check for item in reply.items), sorted(m.SelfTestCheck.values())[1:])
        failed = [m.SelfTestCheck.Name(i.check) for i in reply.items if i.result == m.SELF_TEST_FAILED]
        self.assertEqual(failed, [])
        results = {i.check: i for i in reply.items}
        # The detectors' own noise: at least the converter's rounding, at most its limit.
        noise = results[m.CHECK_NOISE_CAMERA_1]
        self.assertGreater(noise.value, 1000 / 12)
        self.assertLess(noise.value, noise.limit)


if __name__ == '__main__':
    cl.main()
