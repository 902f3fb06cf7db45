#include "core/printable.h"

#include <gtest/gtest.h>

#include <string>

namespace cairn {
namespace {

TEST(Printable, PlainTextStaysAsItIs) {
  for (const char* text : {"", "photo 1.jpg", "Z\u00fcrich", "\u6771\u4eac", "\U0001f600"}) {
    EXPECT_EQ(Printable(text), text);
  }
}

TEST(Printable, EscapesWhatATerminalObeys) {
  EXPECT_EQ(Printable("a\x1b[2Jb"), "a\\x1b[2Jb");
  EXPECT_EQ(Printable("a\r\n\tb\x7f"), "a\\r\\n\\tb\\x7f");
  EXPECT_EQ(Printable(std::string_view("\0", 1)), "\\x00");
  EXPECT_EQ(Printable("\u009b2J"), "\\u009b2J");  // C1: an escape sequence in one character.
  EXPECT_EQ(Printable("gpj.\u202eexe"), "gpj.\\u202eexe");
}

TEST(Printable, EscapesBytesThatAreNotUtf8) {
  EXPECT_EQ(Printable("\xff"), "\\xff");
  EXPECT_EQ(Printable("\xc3"), "\\xc3");                    // Cut.
  EXPECT_EQ(Printable("\xc0\xaf"), "\\xc0\\xaf");           // Overlong.
  EXPECT_EQ(Printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // A surrogate.
  EXPECT_EQ(Printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(Printable("\xc3"
                      "a"),
            "\\xc3"
            "a");
}

TEST(Printable, LinesKeepTheirEnds) { EXPECT_EQ(PrintableLines("a\nb\x1b"), "a\nb\\x1b"); }

TEST(Excerpt, ShortTextIsWhole) {
  EXPECT_EQ(Excerpt(std::string(kMaxExcerptBytes, 'a')), std::string(kMaxExcerptBytes, 'a'));
}

TEST(Excerpt, LongTextIsCutAndSaysHowLongItIs) {
  EXPECT_EQ(Excerpt(std::string(2'000'000, 'a'), 3), "aaa... (2000000 bytes)");
  EXPECT_EQ(Excerpt("a\u00fc\u00fc", 4), "a\u00fc... (5 bytes)");  // Not within a character.
  EXPECT_LT(Excerpt(std::string(1'000'000, '\x1b')).size(), 500u);
}

}  // namespace
}  // namespace cairn
