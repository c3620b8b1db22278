// SPDX-License-Identifier: GPL-3.0-or-later
// Every way in which a line can fail, against a machine made of a few lines: each ends in a bounded time, in
// an error that says what to do.
#include "host/link/link.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "protocol/schema_hash.hpp"

namespace tetragauge {
namespace {

using std::chrono::milliseconds;

// What a fake machine does with each message of the host: may send, returns false to hang up.
class FakeMachine;
using Behaviour = std::function<bool(FakeMachine&, FrameHeader, const tg_HostMessage&)>;

class FakeMachine {
 public:
  explicit FakeMachine(Behaviour behaviour) : behaviour_(std::move(behaviour)) {
    static int number = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("tetragauge-link-" + std::to_string(::getpid()) + "-" + std::to_string(number++));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof address.sun_path - 1);
    listener_ = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listener_, 1), 0);
    thread_ = std::thread([this] { serve(); });
  }
  ~FakeMachine() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
    std::filesystem::remove(path_);
  }

  std::string device() const { return "unix:" + path_.string(); }
  void send(FrameHeader header, const tg_MachineMessage& message) {
    std::array<uint8_t, kFrameWireBytes> wire;
    send_raw({wire.data(), encode_message(header, message, wire.data())});
  }
  void send_raw(std::span<const uint8_t> bytes) { (void)!::write(fd_, bytes.data(), bytes.size()); }

 private:
  void serve() {
    fd_ = ::accept(listener_, nullptr, nullptr);
    if (fd_ < 0) return;
    FrameReader reader;
    uint8_t byte = 0;
    while (::read(fd_, &byte, 1) == 1) {
      tg_HostMessage message = tg_HostMessage_init_zero;
      if (!reader.push(byte) || !decode_message(reader.frame(), &message)) continue;
      if (!behaviour_(*this, reader.frame().header, message)) break;
    }
    ::close(fd_);
  }

  Behaviour behaviour_;
  std::filesystem::path path_;
  int listener_ = -1, fd_ = -1;
  std::thread thread_;
};

tg_MachineMessage greeting(uint32_t schema_hash = kSchemaHash) {
  tg_MachineMessage reply = tg_MachineMessage_init_zero;
  reply.which_body = tg_MachineMessage_hello_reply_tag;
  reply.body.hello_reply.protocol_version = kProtocolVersion;
  reply.body.hello_reply.schema_hash = schema_hash;
  std::strcpy(reply.body.hello_reply.board, "stm32_h405");
  std::strcpy(reply.body.hello_reply.firmware_version, "9.9.9");
  return reply;
}

Result<std::unique_ptr<Link>> connect_to(const FakeMachine& machine) {
  auto transport = open_transport(machine.device());
  EXPECT_TRUE(transport);
  return Link::connect(std::move(*transport), {.silence = milliseconds(400), .retry = milliseconds(100)});
}

void expect_machine_error(const Error& error, std::initializer_list<const char*> words) {
  EXPECT_EQ(error.kind, ErrorKind::machine);
  for (const char* word : words) EXPECT_NE(error.message.find(word), std::string::npos) << error.message;
}

TEST(OpenTransport, NamesWhatIsWrong) {
  expect_machine_error(open_transport("/dev/ttyNOSUCH").error(), {"/dev/ttyNOSUCH", "no such port"});
  expect_machine_error(open_transport("unix:/nonexistent/socket").error(),
                       {"no such socket", "start the emulator"});
  expect_machine_error(open_transport("tcp:127.0.0.1:1").error(), {"tcp:127.0.0.1:1", "listens"});
  EXPECT_EQ(open_transport("tcp:nonsense").error().kind, ErrorKind::usage);
  EXPECT_EQ(open_transport("").error().kind, ErrorKind::usage);
  const auto file =
      std::filesystem::temp_directory_path() / ("tetragauge-no-port-" + std::to_string(::getpid()));
  ::close(::open(file.c_str(), O_CREAT | O_WRONLY, 0600));
  expect_machine_error(open_transport(file.string()).error(), {"not a serial port"});
  std::filesystem::remove(file);
}

TEST(Link, GreetsAMachine) {
  FakeMachine machine([](FakeMachine& m, FrameHeader header, const tg_HostMessage& message) {
    EXPECT_EQ(message.which_body, tg_HostMessage_hello_tag);
    m.send({Channel::kReply, header.id}, greeting());
    return true;
  });
  const auto link = connect_to(machine);
  ASSERT_TRUE(link) << link.error().message;
  EXPECT_STREQ((*link)->machine().board, "stm32_h405");
}

TEST(Link, SilentFirmwareIsAnErrorInBoundedTime) {
  FakeMachine machine([](FakeMachine&, FrameHeader, const tg_HostMessage&) { return true; });
  const auto start = std::chrono::steady_clock::now();
  const auto link = connect_to(machine);
  ASSERT_FALSE(link);
  expect_machine_error(link.error(), {"no answer", "firmware"});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

TEST(Link, AnotherDeviceIsNotTakenForAMachine) {
  FakeMachine machine([](FakeMachine& m, FrameHeader, const tg_HostMessage&) {
    static constexpr std::array<uint8_t, 12> kOther{'G', 'P', 'G', 'G', 'A', ',', '1', '2', 0, 'x', 'y', 0};
    m.send_raw(kOther);
    return true;
  });
  const auto link = connect_to(machine);
  ASSERT_FALSE(link);
  expect_machine_error(link.error(), {"protocol", "bad frames"});
}

TEST(Link, OtherSchemaSaysWhatToFlash) {
  FakeMachine machine([](FakeMachine& m, FrameHeader header, const tg_HostMessage&) {
    m.send({Channel::kReply, header.id}, greeting(kSchemaHash ^ 1));
    return true;
  });
  const auto link = connect_to(machine);
  ASSERT_FALSE(link);
  expect_machine_error(link.error(), {"9.9.9", "flash", "tetragauge-stm32_h405.elf"});
}

TEST(Link, LostRequestIsRepeatedWithItsId) {
  int requests = 0;
  uint32_t first_id = 0;
  FakeMachine machine([&](FakeMachine& m, FrameHeader header, const tg_HostMessage&) {
    if (++requests == 1) {
      first_id = header.id;
      return true;  // "lost"
    }
    EXPECT_EQ(header.id, first_id);
    m.send({Channel::kReply, header.id}, greeting());
    return true;
  });
  EXPECT_TRUE(connect_to(machine));
}

TEST(Link, RefusalCarriesTheMachinesWords) {
  FakeMachine machine([](FakeMachine& m, FrameHeader header, const tg_HostMessage& message) {
    tg_MachineMessage reply = greeting();
    if (message.which_body != tg_HostMessage_hello_tag) {
      reply = tg_MachineMessage_init_zero;
      reply.which_body = tg_MachineMessage_refused_tag;
      reply.body.refused.state = tg_State_STATE_HOMING;
      std::strcpy(reply.body.refused.detail, "not while homing");
    }
    m.send({Channel::kReply, header.id}, reply);
    return true;
  });
  const auto link = connect_to(machine);
  ASSERT_TRUE(link);
  const auto status = (*link)->status();
  ASSERT_FALSE(status);
  expect_machine_error(status.error(), {"HOMING", "not while homing"});
}

TEST(Link, AnswersHeartbeatsWhileWaiting) {
  std::atomic<uint32_t> answered{0};
  FakeMachine machine([&](FakeMachine& m, FrameHeader header, const tg_HostMessage& message) {
    if (message.which_body == tg_HostMessage_heartbeat_ack_tag) {
      answered = message.body.heartbeat_ack.counter;
      return true;
    }
    m.send({Channel::kReply, header.id}, greeting());
    tg_MachineMessage heartbeat = tg_MachineMessage_init_zero;
    heartbeat.which_body = tg_MachineMessage_heartbeat_tag;
    heartbeat.body.heartbeat.counter = 77;
    m.send({Channel::kEvent, 1}, heartbeat);
    return true;
  });
  const auto link = connect_to(machine);
  ASSERT_TRUE(link);
  for (int i = 0; i < 20 && answered != 77; ++i) ASSERT_TRUE((*link)->wait_for_frame(milliseconds(20)));
  EXPECT_EQ(answered, 77u);
}

TEST(Link, KeepsWhatTheMachineLogsInOrderAndTheNewest) {
  constexpr int kLines = 80;
  FakeMachine machine([](FakeMachine& m, FrameHeader header, const tg_HostMessage& message) {
    if (message.which_body == tg_HostMessage_hello_tag) {
      m.send({Channel::kReply, header.id}, greeting());
      return true;
    }
    for (uint32_t i = 0; i < kLines; ++i) {
      tg_MachineMessage line = tg_MachineMessage_init_zero;
      line.which_body = tg_MachineMessage_log_tag;
      line.body.log.level = tg_LogLevel_LOG_WARNING;
      std::strcpy(line.body.log.text, std::to_string(i).c_str());
      m.send({Channel::kEvent, i + 1}, line);
    }
    tg_MachineMessage status = tg_MachineMessage_init_zero;
    status.which_body = tg_MachineMessage_status_tag;
    m.send({Channel::kReply, header.id}, status);
    return true;
  });
  const auto link = connect_to(machine);
  ASSERT_TRUE(link) << link.error().message;
  EXPECT_FALSE((*link)->next_log());
  ASSERT_TRUE((*link)->status());
  std::vector<int> lines;
  while (const auto line = (*link)->next_log()) {
    EXPECT_EQ(line->level, tg_LogLevel_LOG_WARNING);
    lines.push_back(std::stoi(line->text));
  }
  ASSERT_GE(lines.size(), 10u);
  EXPECT_LT(lines.size(), size_t{kLines}) << "bounded";
  for (size_t i = 0; i < lines.size(); ++i)
    EXPECT_EQ(lines[i], kLines - static_cast<int>(lines.size()) + static_cast<int>(i));
}

TEST(Link, UnpluggedIsAnErrorAtOnce) {
  FakeMachine machine([](FakeMachine& m, FrameHeader header, const tg_HostMessage& message) {
    if (message.which_body != tg_HostMessage_hello_tag) return false;
    m.send({Channel::kReply, header.id}, greeting());
    return true;
  });
  const auto link = connect_to(machine);
  ASSERT_TRUE(link);
  const auto status = (*link)->status();
  ASSERT_FALSE(status);
  expect_machine_error(status.error(), {"connection ended"});
}

}  // namespace
}  // namespace tetragauge
