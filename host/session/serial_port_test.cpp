// SPDX-License-Identifier: GPL-3.0-or-later
// The same session once over a unix socket and once through the real libserialport, over a pseudo-terminal
// that tests/pty_preload lets it open: the scans are equal byte for byte. The preload must be there when a
// program starts, so the serial half runs in a second process of this test program.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <cstdio>

#include "host/base/whole_file.hpp"
#include "host/scan/scan_file.hpp"
#include "host/session/emulated_session.hpp"

namespace tetragauge {
namespace {

constexpr const char* kPort = "TETRAGAUGE_TEST_PORT";
constexpr const char* kOut = "TETRAGAUGE_TEST_OUT";

std::string scan_of(const std::string& device) {
  auto transport = open_transport(device);
  if (!transport) return transport.error().message;
  auto link = Link::connect(std::move(*transport));
  if (!link) return link.error().message;
  const auto measured = run_scan(**link, plan_all_round(4, 16), {.seed = 3});
  return measured ? scan_to_ply(measured->scan) : measured.error().message;
}

// The second process.
TEST(SerialPort, DISABLED_ScanToFile) {
  ASSERT_TRUE(::getenv(kPort) && ::getenv(kOut));
  ASSERT_TRUE(write_whole_file(::getenv(kOut), scan_of(::getenv(kPort))));
}

TEST(SerialPort, ScanIsTheOneOfTheSocket) {
  const auto part = box_file();
  const std::string emulator =
      std::string(TETRAGAUGE_EMULATOR) + " --part " + part.string() + " --seed 3 --listen pty --one-host";
  FILE* output = ::popen(emulator.c_str(), "r");
  ASSERT_TRUE(output);
  std::array<char, 64> line{};
  ASSERT_TRUE(std::fgets(line.data(), line.size(), output));
  const std::string port = std::string(line.data()).substr(0, std::string(line.data()).find('\n'));
  ASSERT_TRUE(port.starts_with("/dev/pts/")) << port;

  const auto out = temporary_file("serial.ply", "");
  const auto self = std::filesystem::read_symlink("/proc/self/exe");
  // A sanitizer's runtime wants to be loaded first; here the preload is.
  const std::string command =
      "env ASAN_OPTIONS=verify_asan_link_order=0 LD_PRELOAD=" TETRAGAUGE_PTY_PRELOAD " " +
      std::string(kPort) + "=" + port + " " + kOut + "=" + out.string() + " " + self.string() +
      " --gtest_also_run_disabled_tests --gtest_filter=SerialPort.DISABLED_ScanToFile >/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(::pclose(output), 0);  // the emulator ended with its host

  auto session = start_session({.part = part, .seed = 3});
  ASSERT_TRUE(session) << session.error().message;
  const auto socket = run_scan(*session->link, plan_all_round(4, 16), {.seed = 3});
  ASSERT_TRUE(socket) << socket.error().message;
  const auto serial = read_whole_file(out);
  ASSERT_TRUE(serial);
  EXPECT_GT(serial->size(), 10'000u) << *serial;
  EXPECT_TRUE(*serial == scan_to_ply(socket->scan)) << serial->substr(0, 300);
}

}  // namespace
}  // namespace tetragauge
