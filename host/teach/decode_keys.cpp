// SPDX-License-Identifier: GPL-3.0-or-later
#include "host/teach/key.hpp"

namespace tetragauge {
namespace {

constexpr char kEscape = '\x1b';

Key plain_key(char byte) {
  switch (byte) {
    case '\r':
    case '\n':
      return {KeyKind::enter};
    case '\t':
      return {KeyKind::tab};
    case '\x03':  // Ctrl-C
      return {KeyKind::interrupt};
    case '\x1a':  // Ctrl-Z
      return {KeyKind::suspend};
    case kEscape:
      return {KeyKind::escape};
    default:
      return {KeyKind::character, byte};
  }
}

// ECMA-48: ESC [ parameters (0x30..0x3f) intermediates (0x20..0x2f) final (0x40..0x7e); ESC O final is what
// terminals send for arrows in application mode. Bytes of the sequence at the start of `text`, 0: not all
// there.
size_t sequence_length(std::string_view text) {
  if (text.size() < 2) return 0;
  if (text[1] == 'O') return text.size() < 3 ? 0 : 3;
  if (text[1] != '[') return 1;  // Escape, then another key
  for (size_t k = 2; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    if (byte >= 0x40 && byte <= 0x7e) return k + 1;
    if (byte < 0x20 || byte > 0x7e) return k;  // broken off
  }
  return 0;
}

}  // namespace

std::vector<Key> KeyDecoder::take(std::string_view bytes) {
  pending_ += bytes;
  std::vector<Key> keys;
  while (!pending_.empty()) {
    if (pending_[0] != kEscape) {
      // Text in other alphabets, pasted or typed, is no key of ours.
      if (static_cast<unsigned char>(pending_[0]) < 0x80) keys.push_back(plain_key(pending_[0]));
      pending_.erase(0, 1);
      continue;
    }
    const size_t length = sequence_length(pending_);
    if (length == 0) break;
    if (length == 1) {
      keys.push_back({KeyKind::escape});
    } else {
      switch (pending_[length - 1]) {
        case 'A':
          keys.push_back({KeyKind::up});
          break;
        case 'B':
          keys.push_back({KeyKind::down});
          break;
        case 'C':
          keys.push_back({KeyKind::right});
          break;
        case 'D':
          keys.push_back({KeyKind::left});
          break;
        default:  // another key, which does nothing
          break;
      }
    }
    pending_.erase(0, length);
  }
  return keys;
}

std::vector<Key> KeyDecoder::rest() {
  if (pending_.empty()) return {};
  pending_.clear();
  return {{KeyKind::escape}};
}

}  // namespace tetragauge
