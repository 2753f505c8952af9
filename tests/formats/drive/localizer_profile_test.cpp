#include "formats/drive/localizer_profile.h"

#include <gtest/gtest.h>

#include "formats/record/codec.h"

namespace sightline {
namespace {

TEST(LocalizerProfile, SaysItsNameVersionAndParameters) {
  const LocalizerProfile profile{"my-ndt", 2, {{"leaf_m", "1"}, {"step_m", "0.1"}}};
  EXPECT_EQ(to_text(profile), "my-ndt v2 (leaf_m=1, step_m=0.1)");
  EXPECT_EQ(to_text(LocalizerProfile{"icp", 0, {}}), "icp v0");
}

TEST(LocalizerProfile, ReadsBackWhatItWrote) {
  const LocalizerProfile profile{"my-ndt", 2, {{"leaf_m", "1"}, {"step_m", "0.1"}}};
  ByteWriter writer;
  encode(profile, writer);
  for (std::size_t size = 0; size <= writer.bytes().size(); ++size) {
    ByteReader reader(std::span(writer.bytes()).first(size));
    LocalizerProfile back;
    decode(reader, back);
    EXPECT_EQ(reader.ok(), size == writer.bytes().size()) << "cut at byte " << size;
    if (reader.ok()) {
      EXPECT_EQ(back, profile);
    }
  }
}

TEST(LocalizerProfile, RefusesNamesThatAVehicleCouldNotTell) {
  EXPECT_TRUE(validate(LocalizerProfile{}));
  for (const std::string& name : {std::string(), std::string("my ndt"), std::string("ndt/2"),
                                  std::string("n\xc3\xa4r"), std::string(65, 'a')}) {
    EXPECT_FALSE(validate(LocalizerProfile{name, 1, {}})) << name;
  }
  EXPECT_FALSE(validate(LocalizerProfile{"a", 1, {{"b", "1"}, {"a", "2"}}})) << "not ascending";
  EXPECT_FALSE(validate(LocalizerProfile{"a", 1, {{"b", "1"}, {"b", "2"}}})) << "twice";
  EXPECT_FALSE(validate(LocalizerProfile{"a", 1, {{"b", ""}}})) << "no value";
}

}  // namespace
}  // namespace sightline
