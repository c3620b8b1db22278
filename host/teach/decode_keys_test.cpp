// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "host/teach/key.hpp"

namespace tetragauge {
namespace {

std::vector<Key> characters(const std::string& text) {
  std::vector<Key> keys;
  for (const char c : text) keys.push_back({KeyKind::character, c});
  return keys;
}

TEST(DecodeKeys, ArrowsInBothModes) {
  KeyDecoder decoder;
  const std::vector<Key> expected{{KeyKind::up}, {KeyKind::down}, {KeyKind::right}, {KeyKind::left}};
  EXPECT_EQ(decoder.take("\x1b[A\x1b[B\x1b[C\x1b[D"), expected);
  EXPECT_EQ(decoder.take("\x1bOA\x1bOB\x1bOC\x1bOD"), expected);
  EXPECT_EQ(decoder.take("\x1b[1;5A"), (std::vector<Key>{{KeyKind::up}})) << "with Ctrl held";
}

// A slow line may cut a sequence anywhere.
TEST(DecodeKeys, SequencesInPieces) {
  const std::string bytes = "a\x1b[A\x1b[1;2Bb\x1bODq";
  for (size_t cut = 0; cut <= bytes.size(); ++cut) {
    KeyDecoder decoder;
    std::vector<Key> keys = decoder.take(bytes.substr(0, cut));
    for (const Key& key : decoder.take(bytes.substr(cut))) keys.push_back(key);
    const std::vector<Key> expected{{KeyKind::character, 'a'}, {KeyKind::up},   {KeyKind::down},
                                    {KeyKind::character, 'b'}, {KeyKind::left}, {KeyKind::character, 'q'}};
    EXPECT_EQ(keys, expected) << cut;
  }
}

TEST(DecodeKeys, EscapeAlone) {
  KeyDecoder decoder;
  EXPECT_TRUE(decoder.take("\x1b").empty());
  EXPECT_EQ(decoder.rest(), (std::vector<Key>{{KeyKind::escape}}));
  EXPECT_TRUE(decoder.rest().empty());
  EXPECT_EQ(decoder.take("\x1bk"), (std::vector<Key>{{KeyKind::escape}, {KeyKind::character, 'k'}}));
}

TEST(DecodeKeys, PlainKeys) {
  KeyDecoder decoder;
  EXPECT_EQ(decoder.take("p +?"), characters("p +?"));
  EXPECT_EQ(decoder.take("\r\t\x03\x1a"),
            (std::vector<Key>{{KeyKind::enter}, {KeyKind::tab}, {KeyKind::interrupt}, {KeyKind::suspend}}));
}

// Function keys, mouse reports, other alphabets, rubbish: nothing that would drop a view.
TEST(DecodeKeys, WhatIsNoKeyDoesNothing) {
  KeyDecoder decoder;
  EXPECT_TRUE(decoder.take("\x1b[3~\x1b[15~\x1b[<0;12;7M\x1bOP").empty());
  EXPECT_TRUE(decoder.take("\xc3\xa4\xe2\x82\xac\xff").empty());
  EXPECT_EQ(decoder.take("\x1b[1\x1b[A"), (std::vector<Key>{{KeyKind::up}})) << "a sequence broken off";
}

}  // namespace
}  // namespace tetragauge
