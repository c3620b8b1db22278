// SPDX-License-Identifier: Apache-2.0
// An object built at its own time in memory of its own: no heap, and no <new>.
//
//   constinit Place<Board> board = {};
//   new (InPlace{board.bytes}) Board(...);
//   board->begin();
#pragma once

#include <cstddef>

namespace tetragauge {

struct InPlace {
  unsigned char* at;
};

template <class T>
struct Place {
  alignas(T) unsigned char bytes[sizeof(T)];
  T& operator*() { return *reinterpret_cast<T*>(bytes); }
  T* operator->() { return reinterpret_cast<T*>(bytes); }
};

}  // namespace tetragauge

inline void* operator new(size_t, tetragauge::InPlace place) noexcept {
  return place.at;
}
