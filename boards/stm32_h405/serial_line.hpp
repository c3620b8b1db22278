// SPDX-License-Identifier: Apache-2.0
// USART1 to the host, 8N1. By DMA: the receiver's stream goes round a ring without end, the transmitter's
// takes one stretch of a ring after another. Without DMA (see begin) every byte is an interrupt.
#pragma once

#include <cstddef>
#include <cstdint>

#include "boards/cortex_m4/chip_bus.hpp"
#include "boards/stm32_h405/pins.hpp"
#include "boards/stm32_h405/registers/dma.hpp"
#include "boards/stm32_h405/registers/usart.hpp"

namespace tetragauge {

template <class Bus>
class SerialLine {
 public:
  // 5 ms at 2,000,000 baud: the main loop looks at least every millisecond.
  static constexpr uint32_t kInBytes = 1024;
  static constexpr uint32_t kOutBytes = 512;

  // `divider`: of the bus clock, clock_tree.hpp. The bus clocks of USART1 and DMA2 are on.
  void begin(uint32_t divider, bool with_dma) {
    dma_ = with_dma;
    pins::LineOut::alternate<Bus>(pins::kUsartFunction, 2, 0);
    pins::LineIn::alternate<Bus>(pins::kUsartFunction, 2,
                                 1);  // pulled up: silence while nothing is plugged in
    I::write(usart1::Brr{}, divider);
    if (dma_) {
      I::write(In::Cr{}, 0);
      I::write(In::Ifcr{}, In::kAllFlags);
      I::write(In::Par{}, usart1::Dr::kAddress);
      I::write(In::M0ar{}, Bus::address_of(in_));
      I::write(In::Ndtr{}, kInBytes);
      I::write(In::kChannel(4) | In::kPriority(1) | In::kMemoryIncrement(1) | In::kCircular(1) | In::kOn(1));
      I::write(Out::Cr{}, 0);
      I::write(Out::Ifcr{}, Out::kAllFlags);
      I::write(Out::Par{}, usart1::Dr::kAddress);
      I::write(usart1::kReceiveByDma(1) | usart1::kTransmitByDma(1));
    }
    const auto on = usart1::kOn(1) | usart1::kReceiverOn(1) | usart1::kTransmitterOn(1);
    I::write(dma_ ? on | usart1::kIdleInterrupt(1) : on | usart1::kReceivedInterrupt(1));
  }

  size_t read(uint8_t* bytes, size_t capacity) {
    // NDTR counts down to the end of the ring (10.5.6).
    const uint32_t head = dma_ ? (kInBytes - I::read(typename In::Ndtr{})) % kInBytes : in_head_;
    Bus::barrier();
    size_t count = 0;
    while (count < capacity && in_tail_ != head) {
      bytes[count++] = in_[in_tail_];
      in_tail_ = (in_tail_ + 1) % kInBytes;
    }
    return count;
  }

  size_t write(const uint8_t* bytes, size_t count) {
    size_t taken = 0;
    const uint32_t tail = out_tail_;
    uint32_t head = out_head_;
    while (taken < count && (head + 1) % kOutBytes != tail) {
      out_[head] = bytes[taken++];
      head = (head + 1) % kOutBytes;
    }
    Gate<Bus> gate;
    out_head_ = head;
    send();
    return taken;
  }

  // Bytes that have not left yet, and how many have: a count that stands still while bytes wait is a line
  // that hangs.
  uint32_t waiting() const { return (out_head_ + kOutBytes - out_tail_) % kOutBytes; }
  uint32_t sent() const { return sent_; }
  bool by_dma() const { return dma_; }

  void on_usart_interrupt() {
    const uint32_t status = I::read(usart1::Sr{});
    if (dma_) {
      // Idle, and errors: reading the status and then the data clears them (30.6.1). Frames have a CRC.
      I::read(usart1::Dr{});
      return;
    }
    if (status & (usart1::kReceived.kMask | usart1::kOverrun.kMask)) {
      const auto byte = static_cast<uint8_t>(I::read(usart1::Dr{}));
      const uint32_t next = (in_head_ + 1) % kInBytes;
      if ((status & usart1::kReceived.kMask) && next != in_tail_) {
        in_[in_head_] = byte;
        in_head_ = next;
      }
    }
    send();
  }

  // The transmitter's stream has ended.
  void on_dma_interrupt() {
    I::write(Out::Ifcr{}, Out::kAllFlags);
    out_tail_ = (out_tail_ + stretch_) % kOutBytes;
    sent_ = sent_ + stretch_;
    stretch_ = 0;
    send();
  }

 private:
  using I = Io<Bus>;
  using In = dma2::Stream<2>;   // channel 4: USART1_RX
  using Out = dma2::Stream<7>;  // channel 4: USART1_TX

  // Within a gate, or in the interrupt.
  void send() {
    if (dma_) {
      if (stretch_ != 0 || out_head_ == out_tail_) return;
      stretch_ = out_head_ > out_tail_ ? out_head_ - out_tail_ : kOutBytes - out_tail_;
      Bus::barrier();
      I::write(Out::M0ar{}, Bus::address_of(out_ + out_tail_));
      I::write(Out::Ndtr{}, stretch_);
      I::write(Out::kChannel(4) | Out::kMemoryIncrement(1) | Out::kDirection(1) | Out::kDoneInterrupt(1) |
               Out::kOn(1));
      return;
    }
    while (out_tail_ != out_head_ && I::is(usart1::kRoom(1))) {
      I::write(usart1::Dr{}, out_[out_tail_]);
      out_tail_ = (out_tail_ + 1) % kOutBytes;
      sent_ = sent_ + 1;
    }
    I::modify(usart1::kRoomInterrupt(out_tail_ != out_head_));
  }

  bool dma_ = false;
  volatile uint32_t in_head_ = 0, in_tail_ = 0;
  volatile uint32_t out_head_ = 0, out_tail_ = 0;
  volatile uint32_t stretch_ = 0;  // bytes that the stream is sending
  volatile uint32_t sent_ = 0;
  uint8_t in_[kInBytes] = {};
  uint8_t out_[kOutBytes] = {};
};

// Whether DMA2 copies memory (stream 1, which nothing else uses): an emulated chip may have none. Bounded.
template <class Bus>
bool dma_works(uint32_t turns) {
  using I = Io<Bus>;
  using Copy = dma2::Stream<1>;
  static volatile uint32_t from[4], to[4];
  for (uint32_t k = 0; k < 4; ++k) {
    from[k] = 0x5A00'0001u * (k + 1);
    to[k] = 0;
  }
  Bus::barrier();
  I::write(Copy::Cr{}, 0);
  I::write(Copy::Ifcr{}, Copy::kAllFlags);
  I::write(Copy::Par{}, Bus::address_of(from));
  I::write(Copy::M0ar{}, Bus::address_of(to));
  I::write(Copy::Ndtr{}, 4);
  I::write(Copy::kNoDirectMode(1) |
           Copy::kThreshold(3));  // from memory to memory only through the FIFO (10.3.6)
  I::write(Copy::kDirection(2) | Copy::kPeripheralIncrement(1) | Copy::kMemoryIncrement(1) |
           Copy::kPeripheralSize(2) | Copy::kMemorySize(2) | Copy::kOn(1));
  if (!I::wait_for(Copy::kDone(1), turns)) return false;
  I::write(Copy::Ifcr{}, Copy::kAllFlags);
  Bus::barrier();
  for (uint32_t k = 0; k < 4; ++k) {
    if (to[k] != from[k]) return false;
  }
  return true;
}

}  // namespace tetragauge
