// SPDX-License-Identifier: GPL-3.0-or-later
// Keys as a terminal sends them: bytes, some of them escape sequences that may arrive in pieces.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tetragauge {

enum class KeyKind { character, up, down, left, right, enter, escape, tab, interrupt, suspend };

struct Key {
  KeyKind kind = KeyKind::character;
  char character = 0;  // of KeyKind::character

  friend bool operator==(const Key&, const Key&) = default;
};

class KeyDecoder {
 public:
  // The keys that are complete.
  std::vector<Key> take(std::string_view bytes);
  // Nothing more has come for a while: what looked like the start of a sequence was the Escape key.
  std::vector<Key> rest();

 private:
  std::string pending_;
};

}  // namespace tetragauge
