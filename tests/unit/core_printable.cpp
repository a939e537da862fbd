// Text from outside, made fit for a screen.

#include "core/printable.h"

#include <gtest/gtest.h>

namespace etendue::text {
namespace {

TEST(Printable, PlainTextStaysAsItIs) {
  for (const char* text : {"", "cbox.exr", "étendue ∫ 光 🌞", "tab is no text"}) EXPECT_EQ(printable(text, 100), text);
}

TEST(Printable, NothingReachesTheTerminal) {
  // Escape sequences, a new line that looks like a message, backspaces, DEL, C1 in UTF-8, order of writing.
  EXPECT_EQ(printable("\x1b[2J\x1b]0;title\x07", 100), "\ufffd[2J\ufffd]0;title\ufffd");
  EXPECT_EQ(printable("a\nerror: b\r\tc\b", 100), "a\ufffderror: b\ufffd\ufffdc\ufffd");
  EXPECT_EQ(printable("\x7f\xc2\x9b"
                      "31m",
                      100),
            "\ufffd\ufffd31m");
  EXPECT_EQ(printable("\u202egnp.exe\u2066\u2028", 100), "\ufffdgnp.exe\ufffd\ufffd");
  EXPECT_EQ(printable(std::string_view("a\0b", 3), 100), "a\ufffdb");
}

TEST(Printable, WhatIsNotUtf8IsReplacedByteByByte) {
  EXPECT_EQ(printable("\xff\xfe", 100), "\ufffd\ufffd");
  EXPECT_EQ(printable("\xc0\x80", 100), "\ufffd\ufffd");            // overlong
  EXPECT_EQ(printable("\xed\xa0\x80", 100), "\ufffd\ufffd\ufffd");  // surrogate
  EXPECT_EQ(printable("ok \xe2\x82", 100), "ok \ufffd\ufffd");      // cut short
}

TEST(Printable, LongTextIsCutBetweenCharacters) {
  EXPECT_EQ(printable("ééééé", 5), "ééééé");
  EXPECT_EQ(printable("éééééé", 5), "ééééé…");
  EXPECT_EQ(text::quoted(std::string(1000, 'x')), '"' + std::string(40, 'x') + "…\"");
  EXPECT_EQ(printable("x", 0), "…");
}

TEST(Printable, LinesAreKeptAndEachIsCut) {
  EXPECT_EQ(printable_lines("one\ntwo\x1b\n"), "one\ntwo\ufffd\n");
  EXPECT_EQ(printable_lines("\n\nno end"), "\n\nno end");
  EXPECT_EQ(printable_lines(std::string(2 * kLongestLine, 'x') + "\ny"), std::string(kLongestLine, 'x') + "…\ny");
}

}  // namespace
}  // namespace etendue::text
