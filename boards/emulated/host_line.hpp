// SPDX-License-Identifier: Apache-2.0
// The emulated board's serial line to its host: a socket or a pseudo-terminal, with the faults it is told to
// have. With a listener, the cable can be plugged into one host after another; without, the line is closed
// for good when the host has gone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "boards/emulated/faulty_wire.hpp"
#include "boards/emulated/host_debts.hpp"

namespace tetragauge {

class HostLine {
 public:
  struct Descriptors {
    int listener_fd = -1;  // -1: none
    int fd = -1;           // -1: no host yet
    bool one_host = true;  // closed when the first host has gone
  };
  explicit HostLine(const Descriptors& descriptors, const sim::Faults& faults = {});  // takes them
  ~HostLine();
  HostLine(const HostLine&) = delete;
  HostLine& operator=(const HostLine&) = delete;

  // Waits up to `timeout_ms` of wall time for bytes of the host (or for a host) and takes them in; they come
  // out at the board's end as the faults allow. False: none came.
  bool wait_for_bytes(int timeout_ms, uint64_t now_ns);
  // The host has gone and none will come.
  bool closed() const { return closed_; }

  // The board's side: what has come by now, and what goes out. Without a host bytes go nowhere, as on a real
  // line.
  size_t read(uint8_t* bytes, size_t capacity, uint64_t now_ns);
  size_t write(const uint8_t* bytes, size_t count, uint64_t now_ns);

  // When the line next does something by itself: bytes held back come out, or a cut ends.
  uint64_t next_event_ns(uint64_t now_ns) const;
  void deliver(uint64_t now_ns);

  // What virtual time waits for, and what it must go on for (host_debts.hpp).
  bool host_owes_answer() const { return host_reads_too_slowly() || (connected() && debts_.owed()); }
  bool host_owes_for_certain() const { return host_reads_too_slowly() || debts_.owes_for_certain(); }
  void forgive_guesses() { debts_.forgive_guesses(); }
  bool host_knows_of_gap() const { return connected() && debts_.knows_of_gap(); }
  bool host_lacks_news() const { return connected() && debts_.news_lost(); }

 private:
  bool connected() const { return fd_ >= 0 && !closed_; }
  bool host_reads_too_slowly() const { return connected() && !outbox_.empty(); }
  void host_gone();
  void flush();

  int listener_fd_, fd_;
  bool one_host_;
  bool closed_ = false;
  std::vector<sim::TimeSpan> cuts_;
  FaultyWire to_board_, to_host_;
  std::vector<uint8_t> outbox_;  // at the host's end, and not yet taken by the operating system
  HostDebts debts_;
};

}  // namespace tetragauge
