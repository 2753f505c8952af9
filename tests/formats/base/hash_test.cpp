#include "formats/base/hash.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Sha256, GivesTheExampleOfTheStandard) {
  EXPECT_EQ(to_hex(sha256(std::string_view("abc"))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256Stream, IsTheDigestOfAllPiecesTogether) {
  Sha256Stream stream;
  for (const std::string_view piece : {"a", "", "bc"}) {
    stream.add(std::as_bytes(std::span(piece)));
  }
  EXPECT_EQ(stream.finish(), sha256(std::string_view("abc")));
}

TEST(DigestBuilder, IsTheDigestOfLengthsAndParts) {
  DigestBuilder builder;
  builder.add(std::string_view("ab"));
  using namespace std::string_view_literals;
  EXPECT_EQ(builder.finish(), sha256("\2\0\0\0\0\0\0\0ab"sv));
}

TEST(DigestBuilder, TellsListsApartThatReadTheSameWhenJoined) {
  DigestBuilder one;
  one.add(std::string_view("ab"));
  one.add(std::string_view("c"));
  DigestBuilder other;
  other.add(std::string_view("a"));
  other.add(std::string_view("bc"));
  EXPECT_NE(one.finish(), other.finish());
}

TEST(Xxh3, GivesThePublishedValueOfNothing) { EXPECT_EQ(xxh3({}), 0x2d06800538d394c2ULL); }

}  // namespace
}  // namespace sightline
