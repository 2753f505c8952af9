#include "formats/foreign/lanes/osm_text.h"

#include <gtest/gtest.h>

#include "tests/support/value_of.h"

namespace sightline {
namespace {

// A line feed that is added behind a carriage return would make the document one of another manner.
TEST(OsmText, IsAddedToAsBeforeOnceAdditionsAreTakenOutAgain) {
  const std::string element = "<relation id=\"1\"><tag k=\"type\" v=\"lanelet\"/></relation>";
  OsmAdditions additions;
  additions.ways = {{"way id=\"-1\"", {"-2"}, {{"area", "yes"}}}};
  additions.of_relations = {{{"observation_range_010", "20"}}};
  for (const std::string before : {"", "\n", "\r\n", "\r", " \r", "\r ", "\r\r"}) {
    for (const std::string line_end : {"", "\n", "\r\n"}) {
      std::string text = "<osm>" + line_end + "<way id=\"11\"></way>";
      text += before + element + line_end + "</osm>" + line_end;
      const std::string added = value_of(with_additions(text, additions));
      const std::string without = value_of(without_additions(added, {"observation_range_"}));
      EXPECT_LT(without.size(), added.size());
      const std::string twice = value_of(with_additions(without, additions));
      EXPECT_EQ(twice, added);
    }
  }
}

}  // namespace
}  // namespace sightline
