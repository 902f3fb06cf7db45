#include "core/match_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/canonical_text.h"
#include "core/error.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string RefusalOf(const std::vector<std::string>& wanted,
                      const std::vector<std::string>& known) {
  try {
    MatchNames(wanted, known);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    return error.what();
  }
  return "no error";
}

TEST(CanonicalText, ComposedAndDecomposedCharactersAreEqual) {
  // u with diaeresis, a with circumflex and dot below (in one, two and three characters), Hangul.
  EXPECT_EQ(CanonicalText("\u00fc"), "u\u0308");
  EXPECT_EQ(CanonicalText("\u1ead"), "a\u0323\u0302");
  EXPECT_EQ(CanonicalText("\u1ea1\u0302"), CanonicalText("\u1ead"));
  EXPECT_EQ(CanonicalText("\ud55c\uae00"), "\u1112\u1161\u11ab\u1100\u1173\u11af");
  EXPECT_EQ(CanonicalText("\u212b"), CanonicalText("A\u030a"));
  EXPECT_EQ(CanonicalText("\u304c"), "\u304b\u3099");
}

TEST(CanonicalText, CaseDoesNotCount) {
  EXPECT_EQ(CanonicalText("IMG_1.JPG"), "img_1.jpg");
  EXPECT_EQ(CanonicalText("\u00dcBER"), CanonicalText("u\u0308ber"));
  EXPECT_EQ(CanonicalText("\u0410\u0411\u0401"), CanonicalText("\u0430\u0431\u0451"));
  EXPECT_EQ(CanonicalText("\u00d8\u00c6"), CanonicalText("\u00f8\u00e6"));
  EXPECT_NE(CanonicalText("\u00d7"), CanonicalText("\u00f7"));
}

TEST(CanonicalText, WhatIsNoUtf8StaysAsItIs) {
  for (const std::string text : {"\xff\xfe", "\xc3", "a\xe2\x82", "\xf0\x9f\x98\x80", "\x80z"}) {
    EXPECT_EQ(CanonicalText(text), text);
  }
}

TEST(MatchNames, EqualNamesComeFirst) {
  const NameMatches matches = MatchNames({"b", "x", "A"}, {"a", "A", "b"});
  EXPECT_THAT(matches.known_of_wanted, ElementsAre(2, -1, 1));
  EXPECT_EQ(matches.num_inexact, 0);
}

TEST(MatchNames, CaseNormalFormAndSlashesDoNotCount) {
  const NameMatches matches =
      MatchNames({"1.JPG", "stra\u00dfe/u\u0308.jpg", "cam\\2.jpg", "./3.jpg"},
                 {"3.jpg", "cam/2.jpg", "1.jpg", "Stra\u00dfe/\u00fc.jpg", "4.jpg"});
  EXPECT_THAT(matches.known_of_wanted, ElementsAre(2, 3, 1, 0));
  EXPECT_EQ(matches.num_inexact, 4);
  EXPECT_EQ(matches.inexact_example, 3);
}

TEST(MatchNames, FoldersInFrontOfEitherNameDoNotCountIfNothingElseMatches) {
  EXPECT_THAT(MatchNames({"a.jpg", "b.jpg"}, {"images/B.jpg", "images/a.jpg"}).known_of_wanted,
              ElementsAre(1, 0));
  EXPECT_THAT(
      MatchNames({"/home/me/x/a.jpg", "C:\\x\\b.jpg"}, {"b.jpg", "x/a.jpg"}).known_of_wanted,
      ElementsAre(1, 0));
  // The folder is a part of the name where any name matches as it is.
  EXPECT_THAT(MatchNames({"a.jpg", "b.jpg"}, {"a.jpg", "other/b.jpg"}).known_of_wanted,
              ElementsAre(0, -1));
  EXPECT_THAT(MatchNames({"aa.jpg"}, {"x/a.jpg"}).known_of_wanted, ElementsAre(-1));
}

TEST(MatchNames, EndingsDoNotCountIfNothingElseMatches) {
  const NameMatches matches =
      MatchNames({"01.HEIC", "02.cr2", "03", "04.jpeg"}, {"04.JPG", "01.jpg", "02.jpg", "03.jpg"});
  EXPECT_THAT(matches.known_of_wanted, ElementsAre(1, 2, 3, 0));
  EXPECT_EQ(matches.num_inexact, 4);
  EXPECT_THAT(MatchNames({"x/01.HEIC"}, {"1/01.jpg", "01.jpg"}).known_of_wanted, ElementsAre(1));
  EXPECT_THAT(MatchNames({"1/01.HEIC"}, {"1/01.jpg", "2/01.jpg"}).known_of_wanted, ElementsAre(0));
  // Another way that matches any name excludes this one.
  EXPECT_THAT(MatchNames({"01.JPG", "02.png"}, {"01.jpg", "02.jpg"}).known_of_wanted,
              ElementsAre(0, -1));
  EXPECT_THAT(MatchNames({"01.jpg", "02.png"}, {"x/01.jpg", "x/02.jpg"}).known_of_wanted,
              ElementsAre(0, -1));
}

TEST(MatchNames, WhatIsNoEndingCounts) {
  for (const char* other : {"IMG_2026.12", ".jpg", "a/.jpg", "IMG_2026.jp-g", "IMG_2026.edited"}) {
    EXPECT_THAT(MatchNames({other}, {"IMG_2026.11"}).known_of_wanted, ElementsAre(-1)) << other;
    EXPECT_THAT(MatchNames({other}, {"IMG_2026.jpg"}).known_of_wanted, ElementsAre(-1)) << other;
  }
}

TEST(MatchNames, AStemOfTwoPhotosIsRefused) {
  EXPECT_THAT(RefusalOf({"01.HEIC"}, {"01.jpg", "01.png"}), HasSubstr("could be"));
  EXPECT_THAT(RefusalOf({"01.HEIC", "01.MOV"}, {"01.jpg"}), HasSubstr("could be"));
  EXPECT_THAT(RefusalOf({"01.HEIC"}, {"1/01.jpg", "2/01.jpg"}), HasSubstr("could be"));
}

TEST(MatchNames, ANameThatCouldBeEitherOfTwoIsRefused) {
  EXPECT_THAT(RefusalOf({"a.jpg"}, {"A.jpg", "a.JPG"}),
              ::testing::AllOf(HasSubstr("'a.jpg'"), HasSubstr("'A.jpg'"), HasSubstr("'a.JPG'")));
  EXPECT_THAT(RefusalOf({"A.jpg", "a.JPG"}, {"a.jpg"}), HasSubstr("could be"));
  EXPECT_THAT(RefusalOf({"a.jpg"}, {"1/a.jpg", "2/a.jpg"}), HasSubstr("could be"));
  EXPECT_THAT(RefusalOf({"1/a.jpg", "2/a.jpg"}, {"a.jpg"}), HasSubstr("could be"));
  EXPECT_EQ(RefusalOf({"a.jpg", "A.jpg"}, {"a.jpg"}), "no error");  // One is equal.
}

TEST(MatchNames, ANameMayBeListedTwice) {
  EXPECT_THAT(MatchNames({"A", "A"}, {"a"}).known_of_wanted, ElementsAre(0, 0));
  EXPECT_THAT(MatchNames({"a", "a"}, {"a"}).known_of_wanted, ElementsAre(0, 0));
}

TEST(InexactExample, NamesBoth) {
  const std::vector<std::string> wanted = {"01.HEIC"}, known = {"00.jpg", "01.jpg"};
  EXPECT_EQ(InexactExample(MatchNames(wanted, known), wanted, known), "'01.HEIC' as '01.jpg'");
}

TEST(ExampleNames, AreFew) {
  EXPECT_EQ(ExampleNames({}), "none");
  EXPECT_EQ(ExampleNames({"a", "b"}), "'a', 'b'");
  EXPECT_EQ(ExampleNames({"a", "b", "c", "d", "e"}), "'a', 'b', 'c' and 2 others");
}

}  // namespace
}  // namespace cairn
